"""A twin file joined to its FMUs: each name it uses is a variable that can play its part."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from gmfbo.errors import FmuFileError, TwinFileError
from gmfbo.sources.bound_variable import BoundVariable
from gmfbo.sources.description import FmuDescription, read_description
from gmfbo.sources.job import Wire
from gmfbo.sources.misfits import find_misfits, is_parameter
from gmfbo.sources.models import models_folder
from gmfbo.sources.twin_file import ControllerEntry, TwinFile

_SHOWN = 3


@dataclass(frozen=True)
class Binding:
    """FMUs of a twin and their variables.

    Attributes
    ----------
    file : TwinFile
        What was bound.
    label : str
        Name of the file, for messages.
    fmus : tuple of FmuDescription
        In order of computation.
    content : tuple of str
        SHA-256 of each FMU's bytes.
    variables : mapping of str to BoundVariable
        By the names that the twin file uses.
    preset : mapping of str to float
        Settings of the project's own controllers, below [parameters].
    """

    file: TwinFile
    label: str
    fmus: tuple[FmuDescription, ...]
    content: tuple[str, ...]
    variables: Mapping[str, BoundVariable]
    preset: Mapping[str, float]

    @cached_property
    def parameters(self) -> dict[str, BoundVariable]:
        """All parameters that are numbers, and inputs that [parameters] holds at a value."""
        held = self.file.parameters
        return {
            name: v
            for name, v in self.variables.items()
            if is_parameter(v.variable) or name in held
        }

    @property
    def wires(self) -> tuple[Wire, ...]:
        """From outputs to inputs, as the twin file joins its FMUs."""
        return tuple(
            self.variables[target].wire_from(self.variables[source])
            for target, source in self.file.wires.items()
        )

    def nominal(self, name: str) -> float:
        """Value [FMU's unit] of a parameter as the twin file leaves it."""
        if name in self.settings:
            return self.settings[name]
        start = self.variables[name].variable.start
        return 0.0 if start is None else start

    @property
    def settings(self) -> dict[str, float]:
        """Values [FMU's unit] that the twin file gives to parameters."""
        fixed = {name: gain.low for name, gain in self.file.gains.items() if gain.fixed}
        return {**self.preset, **self.file.parameters, **fixed}


def bind(file: TwinFile, folder: Path, label: str) -> Binding:
    """Find every FMU and variable that a twin file names; no code of an FMU runs.

    Parameters
    ----------
    file : TwinFile
        What to bind.
    folder : Path
        Where its paths begin.
    label : str
        Name of the file, for messages.

    Raises
    ------
    TwinFileError
        A name is not there, or cannot play its part: file, key and nearest name in one line.
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
    binding = Binding(file, label, tuple(fmus), content, variables, preset)
    problems = list(dict.fromkeys(find_misfits(binding)))
    if problems:
        more = f"; and {len(problems) - _SHOWN} more" if len(problems) > _SHOWN else ""
        raise TwinFileError(f"{label}: " + "; ".join(problems[:_SHOWN]) + more)
    return binding


def content_of(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _fmu_paths(file: TwinFile, folder: Path) -> dict[str, Path]:
    if file.fmu is not None:
        return {"": folder / file.fmu}
    return {
        prefix: models_folder() / f"{entry.kind}.fmu"
        if isinstance(entry, ControllerEntry)
        else folder / entry
        for prefix, entry in file.fmus.items()
    }
