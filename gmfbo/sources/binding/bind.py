"""Join a twin file to its FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gmfbo.errors import FmuFileError, TwinFileError
from gmfbo.sources.binding.binding import Binding, content_of
from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.binding.misfits import find_misfits
from gmfbo.sources.fmu_file.description import FmuDescription, read_description
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin_file.twin_file import ControllerEntry, TwinFile

_SHOWN = 3


def bind(file: TwinFile, folder: Path, label: str) -> Binding:
    """Find every FMU and variable that a twin file names; no code of an FMU runs.

    Raises
    ------
    TwinFileError
        A name does not exist or is of the wrong kind: file, key and nearest name in one line.
    FmuFileError
        An FMU cannot be read, or cannot run on this machine.
    """
    sources = _fmu_paths(file, folder)
    fmus = []
    for path in sources.values():
        if not path.is_file():
            raise FmuFileError(f"{label}: no FMU at '{path}'; check the path in the twin file")
        fmus.append(read_description(path))
        fmus[-1].library()
    variables = {
        f"{prefix}.{name}" if file.fmus else name: BoundVariable(
            f"{prefix}.{name}" if file.fmus else name, index, variable
        )
        for index, (prefix, fmu) in enumerate(zip(sources, fmus, strict=True))
        for name, variable in fmu.variables.items()
    }
    content = tuple(content_of(path) for path in sources.values())
    preset = {
        f"{prefix}.{name}": float(value)
        for prefix, entry in file.fmus.items()
        if isinstance(entry, ControllerEntry)
        for name, value in entry.settings.items()
    }
    binding = Binding(
        file, label, tuple(fmus), content, variables, preset, _default_start(file, fmus)
    )
    problems = list(dict.fromkeys(find_misfits(binding)))
    if problems:
        more = f"; and {len(problems) - _SHOWN} more" if len(problems) > _SHOWN else ""
        raise TwinFileError(f"{label}: " + "; ".join(problems[:_SHOWN]) + more)
    return binding


def _default_start(file: TwinFile, fmus: Sequence[FmuDescription]) -> float:
    """[s] Start time that the first of the user's own FMUs states; 0 where none does."""
    entries: list[str | ControllerEntry] = list(file.fmus.values()) or [file.fmu or ""]
    stated = [
        fmu.default_start
        for fmu, entry in zip(fmus, entries, strict=True)
        if fmu.default_start is not None and not isinstance(entry, ControllerEntry)
    ]
    return stated[0] if stated else 0.0


def _fmu_paths(file: TwinFile, folder: Path) -> dict[str, Path]:
    if file.fmu is not None:
        return {"": folder / file.fmu}
    return {
        prefix: models_folder() / f"{entry.kind}.fmu"
        if isinstance(entry, ControllerEntry)
        else folder / entry
        for prefix, entry in file.fmus.items()
    }
