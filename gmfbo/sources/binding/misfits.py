"""Names in a twin file that are no variable of its FMUs, or a variable of the wrong kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from difflib import get_close_matches
from math import prod
from typing import TYPE_CHECKING

from gmfbo.errors import InputError, did_you_mean
from gmfbo.sources.binding.name_patterns import matching
from gmfbo.sources.binding.table_nodes import LEAST_NODES, elements, shape_of
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable, is_parameter
from gmfbo.sources.fmu_file.job import ValueType
from gmfbo.sources.twin_file.twin_file import ControllerEntry, SignalEntry

if TYPE_CHECKING:
    from gmfbo.sources.binding.binding import Binding


def _is_input(variable: FmuVariable) -> bool:
    return variable.causality == "input" and variable.value_type is not None


def _is_readable(variable: FmuVariable) -> bool:
    # Many vendors declare the signals of interest as local variables, not as outputs.
    return variable.causality in ("output", "local") and variable.value_type is not None


Part = tuple[str, Callable[[FmuVariable], bool]]
_PARAMETER: Part = ("a parameter", is_parameter)
_INPUT: Part = ("an input", _is_input)
_OUTPUT: Part = ("an output", _is_readable)


def find_misfits(binding: Binding) -> Iterator[str]:
    """Describe each unknown or unsuitable name, and each value out of bounds.

    Parameters
    ----------
    binding : Binding
        The twin file and the variables of its FMUs.
    """
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
    yield from _fixed_problems(binding)
    yield from _table_problems(binding)
    yield from _column_slips(binding)
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
    elif shape := found.variable.shape:
        size = " x ".join(map(str, shape))
        yield (
            f"{where}: expected a single number, '{name}' is an array of {size}; "
            + _element_hint(binding, name)
        )
    elif found.variable.value_type is None:
        yield f"{where}: expected a number, '{name}' is of type {found.variable.type}"
    elif not fits(found.variable):
        choices = [known for known, v in binding.variables.items() if fits(v.variable)]
        # An existing name is no spelling error, so the nearest spelling is no help.
        shown = ", ".join(choices[:6]) + (", ..." if len(choices) > 6 else "")
        valid = f"; such are {shown}" if choices else "; it has none"
        is_a = f"'{name}' is of causality {found.variable.causality}"
        yield f"{where}: expected {words} of the FMU, {is_a}{valid}"


def _element_hint(binding: Binding, name: str) -> str:
    if not binding.variables[name].variable.split:
        return "ask its vendor for an export with scalar variables"
    first = next(known for known in binding.variables if known.startswith(f"{name}["))
    return f"name one of its elements, such as '{first}'"


def _fixed_problems(binding: Binding) -> Iterator[str]:
    for pattern in binding.file.fixed.names:
        found = matching(pattern, binding.parameters)
        if not found:
            near = did_you_mean(pattern, binding.parameters)
            yield f"[fixed] names: no parameter matches '{pattern}'{near}"
        for name in found:
            if name in binding.file.uncertain:
                yield f"[fixed] names: '{pattern}' holds '{name}' of [uncertain]; keep one"


def _table_problems(binding: Binding) -> Iterator[str]:
    for table, entry in binding.file.tables.items():
        where = f"[tables] '{table}'"
        found = elements(entry.nodes, binding.variables)
        whole = len({len(index) for index in found}) == 1 and len(found) == prod(shape_of(found))
        if not whole or len(found) < LEAST_NODES:
            stems = {name.partition("[")[0] for name in binding.variables if "[" in name}
            yield (
                f"{where} nodes: expected {LEAST_NODES} or more variables {entry.nodes}[1], ... or "
                f"{entry.nodes}[1,1], ... of the FMU, found {len(found)}"
            ) + did_you_mean(entry.nodes, stems - {entry.nodes})
            continue
        part = _OUTPUT if entry.deltas else _PARAMETER
        for name in found.values():
            yield from _misfit(binding, f"{where} nodes", name, part)
        if entry.deltas is None:
            continue
        added = elements(entry.deltas, binding.variables)
        if added.keys() != found.keys():
            yield (
                f"{where} deltas: expected a parameter {entry.deltas}[...] for each of the "
                f"{len(found)} nodes, found {len(added)}"
            )
        for name in added.values():
            yield from _misfit(binding, f"{where} deltas", name, _PARAMETER)


def _column_slips(binding: Binding) -> Iterator[str]:
    """Column names that nearly equal a signal of this twin; other twins' signals are allowed."""
    file = binding.file
    known = {*file.inputs, *file.outputs, *binding.parameters, "time"}
    for name in sorted(file.columns.keys() - known):
        plain = name.lower()
        nearest = get_close_matches(plain, [n.lower() for n in known], n=1, cutoff=0.85)
        # position_2 beside position is another sensor.
        if nearest and plain.rstrip("_0123456789") != nearest[0].rstrip("_0123456789"):
            yield f"[columns] '{name}': no such signal or parameter{did_you_mean(name, known)}"


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
    moved = {entry.variable for entry in file.inputs.values()} | {*file.wires, *file.ports.values()}
    # Exporters offer constants as inputs; an input that nothing drives keeps its start value.
    held = (
        "a parameter, or an input that nothing drives,",
        lambda v: is_parameter(v) or _is_input(v),
    )
    yield from _word_problems(binding)
    for table, name, numbers in values:
        where = f"[{table}]"
        part = held if table == "parameters" and name not in moved else _PARAMETER
        misfit = list(_misfit(binding, f"{where} '{name}'", name, part))
        yield from misfit
        for value in () if misfit else numbers:
            yield from _bounds_problem(binding, where, name, value)


def _word_problems(binding: Binding) -> Iterator[str]:
    """Texts of [parameters] that are no value of their parameter's type."""
    for name, word in binding.file.words.items():
        try:
            given = binding.given({name: word})
        except InputError as error:
            yield "[parameters] " + str(error).removeprefix(f"{binding.file.name}: ")
            continue
        for number in given.numbers.values():
            yield from _bounds_problem(binding, "[parameters]", name, number)


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
        elif source == "fit" and not misfit:
            yield from _fitted_start_problems(binding, name)


def _fitted_start_problems(binding: Binding, name: str) -> Iterator[str]:
    """A start that is to be fitted and cannot, or of which something else is said too."""
    file, kind = binding.file, binding.variables[name].variable.value_type
    if kind not in (ValueType.REAL, ValueType.FLOAT32):
        yield f"[initial] '{name}' = \"fit\": expected a real number to fit; give its value"
    tables = {
        "uncertain": [*file.uncertain],
        "parameters": [*file.parameters],
        "gains": [*file.gains],
        "fixed": [n for p in file.fixed.names for n in matching(p, binding.parameters)],
    }
    for table, names in tables.items():
        if name in names:
            yield f"[initial] '{name}' = \"fit\" and [{table}] both say what it is: remove one"


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
