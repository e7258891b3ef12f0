"""Shell completion at TAB; it imports nothing heavy, since a user waits."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from importlib.metadata import entry_points
from pathlib import Path

Completion = Callable[[str], list[str]]

_PLAIN = re.compile(r"[\w@%+=:,./~-]+", re.ASCII)
"""Names that no shell needs quoted."""


def paths_ending(*endings: str) -> Completion:
    """Make a completion of files and folders by the ends of their names.

    Where none fits, or one would have to be quoted, it offers nothing: the shell then completes
    any path by itself.

    Parameters
    ----------
    *endings : str
        Such as `.toml`.
    """

    def complete(incomplete: str) -> list[str]:
        folder, begun = os.path.split(incomplete)
        try:
            names = sorted(path.name for path in Path(folder or ".").expanduser().iterdir())
        except OSError:
            return []
        fitting = [name for name in names if name.startswith(begun) and name.endswith(endings)]
        paths = [os.path.join(folder, name) for name in fitting]  # noqa: PTH118 - keeps "./"
        return paths if all(_PLAIN.fullmatch(path) for path in paths) else []

    return complete


def methods(incomplete: str) -> list[str]:
    """Names of tuning methods that are not yet in a list with commas.

    Parameters
    ----------
    incomplete : str
        The list so far.
    """
    from gmfbo.tuning.query.method_names import ADDED_GROUP, METHOD_NAMES

    done, comma, begun = incomplete.rpartition(",")
    given = {entry.partition(":")[0] for entry in done.split(",")}
    known = [*METHOD_NAMES, *(entry.name for entry in entry_points(group=ADDED_GROUP))]
    return [f"{done}{comma}{name}" for name in _beginning(begun, known) if name not in given]


def effects(incomplete: str) -> list[str]:
    """Names of effects of the catalogue.

    Parameters
    ----------
    incomplete : str
        How it begins.
    """
    from gmfbo.physics import CATALOGUE

    return _beginning(incomplete, CATALOGUE)


def dialects(incomplete: str) -> list[str]:
    """Names of the dialects of text files.

    Parameters
    ----------
    incomplete : str
        How it begins.
    """
    from gmfbo.recordings.columns.column_mapping import DIALECTS

    return _beginning(incomplete, DIALECTS)


def compilers(incomplete: str) -> list[str]:
    """Compilers of the project's FMUs.

    Parameters
    ----------
    incomplete : str
        How it begins.
    """
    return _beginning(incomplete, ("zig", "system"))


def models(incomplete: str) -> list[str]:
    """Names of the project's FMUs that can be built from this checkout.

    Parameters
    ----------
    incomplete : str
        How it begins.
    """
    sources = Path(__file__).resolve().parents[2] / "fmu_build"
    return _beginning(incomplete, sorted(path.parent.name for path in sources.glob("*/model.toml")))


def _beginning(begun: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(begun)]
