"""Shell completion at TAB; it imports nothing heavy, since a user waits."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
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
    """Names of tuning methods that are not yet in a list with commas."""
    import gmfbo.retuning  # noqa: F401 - adds its methods
    from gmfbo.tuning.methods import METHODS

    done, comma, begun = incomplete.rpartition(",")
    given = {entry.partition(":")[0] for entry in done.split(",")}
    fitting = _beginning(begun, METHODS.names())
    return [f"{done}{comma}{name}" for name in fitting if name not in given]


def _names_of(known: Callable[[], Iterable[str]]) -> Completion:
    """Complete names that are looked up at TAB, so that nothing loads before."""

    def complete(incomplete: str) -> list[str]:
        return _beginning(incomplete, known())

    return complete


def _effects() -> Iterable[str]:
    from gmfbo.physics import CATALOGUE

    return CATALOGUE


def _dialects() -> Iterable[str]:
    from gmfbo.recordings.columns.column_mapping import DIALECTS

    return DIALECTS


def _presets() -> Iterable[str]:
    from gmfbo.recordings.columns.presets import PRESETS

    return PRESETS


def _models() -> Iterable[str]:
    """The project's FMUs that can be built from this checkout."""
    sources = Path(__file__).resolve().parents[2] / "fmu_build"
    return sorted(path.parent.name for path in sources.glob("*/model.toml"))


effects, dialects, models = _names_of(_effects), _names_of(_dialects), _names_of(_models)
presets = _names_of(_presets)
compilers = _names_of(lambda: ("zig", "system"))


def _beginning(begun: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(begun)]
