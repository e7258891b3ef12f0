"""A twin file joined to its FMUs: each name is a variable of the right kind."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.binding.words import GivenValues, given_values
from gmfbo.sources.fmu_file.description import FmuDescription
from gmfbo.sources.fmu_file.fmu_variable import is_parameter
from gmfbo.sources.fmu_file.job import Wire
from gmfbo.sources.twin_file.twin_file import TwinFile


@dataclass(frozen=True)
class Binding:
    """FMUs of a twin and their variables.

    Attributes
    ----------
    file : TwinFile
        The bound twin file.
    label : str
        Name of the file, for messages.
    fmus : tuple of FmuDescription
        In order of computation.
    content : tuple of str
        SHA-256 of each FMU's bytes.
    variables : mapping of str to BoundVariable
        By the names that the twin file uses.
    preset : mapping of str to float
        Settings of the project's own controllers; [parameters] overrides them.
    default_start : float
        [s] Start time of the default experiment of the first of the user's FMUs that states one.
    """

    file: TwinFile
    label: str
    fmus: tuple[FmuDescription, ...]
    content: tuple[str, ...]
    variables: Mapping[str, BoundVariable]
    preset: Mapping[str, float]
    default_start: float = 0.0

    @cached_property
    def parameters(self) -> dict[str, BoundVariable]:
        """All parameters that are numbers, and inputs that [parameters] holds at a value."""
        held = {*self.file.parameters, *self.file.words}
        return {
            name: v
            for name, v in self.variables.items()
            if is_parameter(v.variable) or (name in held and v.variable.value_type is not None)
        }

    @cached_property
    def words(self) -> GivenValues:
        """Entries of [parameters] that are texts in the file, sorted by their type."""
        return self.given(self.file.words)

    def given(self, values: Mapping[str, float | str]) -> GivenValues:
        """Sort values of parameters, as numbers or as words, by the type of their parameter.

        Parameters
        ----------
        values : mapping of str to float or str
            By name.

        Raises
        ------
        InputError
            A name is unknown, or a word is no value of its parameter's type.
        """
        return given_values(self.file.name, self.variables, self.parameters, values)

    @property
    def wires(self) -> tuple[Wire, ...]:
        """Wires from outputs to inputs, as the twin file joins its FMUs."""
        return tuple(
            self.variables[target].wire_from(self.variables[source])
            for target, source in self.file.wires.items()
        )

    def start_time(self, recorded: float) -> float:
        """[s] FMU time at which a run begins.

        Parameters
        ----------
        recorded : float
            [s] First time of the recording that is followed.
        """
        return recorded if self.file.recording.clock == "fmu" else self.default_start

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
        return {**self.preset, **self.file.parameters, **self.words.numbers, **fixed}


def content_of(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
