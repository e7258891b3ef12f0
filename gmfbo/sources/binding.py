"""A twin file joined to its FMUs: each name it uses is a variable that can play its part."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from gmfbo.errors import FmuFileError, InputError, TwinFileError, did_you_mean
from gmfbo.sources.description import FmuDescription, FmuVariable, read_description
from gmfbo.sources.job import Port, Setting, Wire
from gmfbo.sources.models import models_folder
from gmfbo.sources.twin_file import ControllerEntry, SignalEntry, TwinFile

_SHOWN = 3


@dataclass(frozen=True)
class BoundVariable:
    """A variable of one of the twin's FMUs.

    Attributes
    ----------
    name : str
        As the twin file writes it, with the FMU's prefix where there are several.
    fmu : int
        Place of the FMU in the order of computation.
    variable : FmuVariable
        What the FMU says of it.
    """

    name: str
    fmu: int
    variable: FmuVariable

    def port(self, column: int) -> Port:
        """Join it to a column of an array."""
        return Port(self.fmu, self.variable.reference, self._type, column)

    def setting(self, value: float) -> Setting:
        """Value [FMU's unit] before initialisation."""
        return Setting(self.fmu, self.variable.reference, self._type, value)

    def wire_from(self, source: BoundVariable) -> Wire:
        """Drive this input by an output."""
        return Wire(
            *(self.fmu, self.variable.reference, self._type),
            *(source.fmu, source.variable.reference, source._type),
        )

    def check_value(self, value: float) -> None:
        """Refuse a value that the FMU's bounds exclude.

        Parameters
        ----------
        value : float
            [FMU's unit]

        Raises
        ------
        InputError
            The message names variable, bounds and value.
        """
        low, high = self.variable.minimum, self.variable.maximum
        below = low is not None and value < low
        above = high is not None and value > high
        if below or above or value != value or value in (float("inf"), float("-inf")):
            shown = [f"{low:g}" if low is not None else "-inf"]
            shown.append(f"{high:g}" if high is not None else "inf")
            unit = f" {self.variable.unit}" if self.variable.unit else ""
            raise InputError(
                f"parameter '{self.name}': expected a value within [{', '.join(shown)}]{unit}, "
                f"the FMU's bounds, got {value:g}"
            )
        if self._type != 0 and value != round(value):
            raise InputError(
                f"parameter '{self.name}': expected a whole number, it is of type "
                f"{self.variable.type}, got {value:g}"
            )

    @property
    def _type(self) -> int:
        value_type = self.variable.value_type
        assert value_type is not None, "texts are refused when the file is bound"
        return int(value_type)


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

    @property
    def parameters(self) -> dict[str, BoundVariable]:
        """All parameters that are numbers, by name."""
        return {name: v for name, v in self.variables.items() if _is_parameter(v.variable)}

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
    problems = list(dict.fromkeys(_problems(binding)))
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


# ---- which variable can play which part -----------------------------------------------------


def _is_parameter(variable: FmuVariable) -> bool:
    return variable.causality == "parameter" and variable.value_type is not None


def _is_input(variable: FmuVariable) -> bool:
    return variable.causality == "input" and variable.value_type is not None


def _is_readable(variable: FmuVariable) -> bool:
    # Many vendors leave what an engineer compares among the local variables.
    return variable.causality in ("output", "local") and variable.value_type is not None


Part = tuple[str, Callable[[FmuVariable], bool]]
_PARAMETER: Part = ("a parameter", _is_parameter)
_INPUT: Part = ("an input", _is_input)
_OUTPUT: Part = ("an output", _is_readable)


def _problems(binding: Binding) -> Iterator[str]:
    file = binding.file
    for table, entries, part in (
        ("inputs", file.inputs, _INPUT),
        ("outputs", file.outputs, _OUTPUT),
    ):
        for signal, entry in entries.items():
            where = f"[{table}] '{signal}'"
            yield from _misfit(binding, where, entry.variable, part)
            yield from _scale_problem(binding, where, entry)
    for table, names, part in (
        ("ports", file.ports, _INPUT),
        ("states", file.states, _OUTPUT),
        ("roles", file.roles, _PARAMETER),
    ):
        for key, name in names.items():
            yield from _misfit(binding, f"[{table}] '{key}'", name, part)
    yield from _controller_problems(binding)
    yield from _value_problems(binding)
    yield from _initial_problems(binding)
    yield from _wire_problems(binding)


def _misfit(binding: Binding, where: str, name: str, part: Part) -> Iterator[str]:
    words, fits = part
    found = binding.variables.get(name)
    if found is None:
        choices = [known for known, v in binding.variables.items() if fits(v.variable)]
        yield f"{where}: no FMU variable '{name}'" + did_you_mean(name, choices)
    elif found.variable.value_type is None:
        yield f"{where}: expected a number, '{name}' is of type {found.variable.type}"
    elif not fits(found.variable):
        choices = [known for known, v in binding.variables.items() if fits(v.variable)]
        # A name that exists is no slip of the pen, so the nearest spelling is no help.
        shown = ", ".join(choices[:6]) + (", ..." if len(choices) > 6 else "")
        valid = f"; such are {shown}" if choices else "; it has none"
        is_a = f"'{name}' is of causality {found.variable.causality}"
        yield f"{where}: expected {words} of the FMU, {is_a}{valid}"


def _scale_problem(binding: Binding, where: str, entry: SignalEntry) -> Iterator[str]:
    if isinstance(entry.scale, str):
        yield from _misfit(binding, f"{where} scale", entry.scale, _PARAMETER)


def _controller_problems(binding: Binding) -> Iterator[str]:
    for prefix, entry in binding.file.fmus.items():
        if not isinstance(entry, ControllerEntry):
            continue
        for name in entry.settings:
            full = f"{prefix}.{name}"
            known = [
                parameter.removeprefix(f"{prefix}.")
                for parameter in binding.parameters
                if parameter.startswith(f"{prefix}.")
            ]
            if full not in binding.parameters:
                yield f"[fmus] '{prefix}': no parameter '{name}' of {entry.kind}" + did_you_mean(
                    name, known
                )
            else:
                yield from _bounds_problem(
                    binding, f"[fmus] '{prefix}'", full, entry.settings[name]
                )


def _value_problems(binding: Binding) -> Iterator[str]:
    file = binding.file
    ranges = {name: (gain.low, gain.high) for name, gain in file.gains.items()}
    values = (
        *(("parameters", name, (value,)) for name, value in file.parameters.items()),
        *(("gains", name, pair) for name, pair in ranges.items()),
        *(("uncertain", name, pair) for name, pair in file.uncertain.items()),
    )
    for table, name, numbers in values:
        where = f"[{table}]"
        misfit = list(_misfit(binding, f"{where} '{name}'", name, _PARAMETER))
        yield from misfit
        for value in () if misfit else numbers:
            yield from _bounds_problem(binding, where, name, value)


def _bounds_problem(binding: Binding, where: str, name: str, value: float) -> Iterator[str]:
    try:
        binding.variables[name].check_value(value)
    except InputError as error:
        yield f"{where} {error}"


def _initial_problems(binding: Binding) -> Iterator[str]:
    signals = {**binding.file.inputs, **binding.file.outputs}
    for name, source in binding.file.initial.items():
        misfit = list(_misfit(binding, f"[initial] '{name}'", name, _PARAMETER))
        yield from misfit
        if isinstance(source, str) and source != "fit" and source not in signals:
            yield f"[initial] '{name}': no signal '{source}'" + did_you_mean(source, signals)
        elif not isinstance(source, str) and not misfit:
            yield from _bounds_problem(binding, "[initial]", name, source)


def _wire_problems(binding: Binding) -> Iterator[str]:
    driven = {entry.variable: signal for signal, entry in binding.file.inputs.items()}
    for target, source in binding.file.wires.items():
        yield from _misfit(binding, f"[wires] '{target}'", target, _INPUT)
        yield from _misfit(binding, f"[wires] '{target}'", source, _OUTPUT)
        if target in driven:
            yield f"[wires] '{target}': signal '{driven[target]}' of [inputs] drives it already"
    seen: dict[str, str] = {}
    for signal, entry in binding.file.inputs.items():
        if entry.variable in seen:
            yield (
                f"[inputs] '{signal}': signal '{seen[entry.variable]}' drives "
                f"'{entry.variable}' already"
            )
        seen.setdefault(entry.variable, signal)
