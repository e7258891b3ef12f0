"""Names of FMU variables by shell patterns."""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Names that a pattern stands for; a name stands for itself, `map[1]` too.

    Parameters
    ----------
    pattern : str
        A name, or a shell pattern with `*`, `?` or `[...]`.
    names : iterable of str
        Known names.
    """
    known = list(names)
    return [pattern] if pattern in known else [n for n in known if fnmatchcase(n, pattern)]
