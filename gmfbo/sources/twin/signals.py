"""Convert a twin's signals between the recording's SI units and the FMU's units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.recording import Recording
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.fmu_variable import FmuVariable
from gmfbo.sources.twin.sampling import sample
from gmfbo.sources.twin_file.twin_file import OutputEntry, SignalEntry
from gmfbo.units import parse_unit


def signal_specs(binding: Binding, override: Mapping[str, float]) -> dict[str, SignalSpec]:
    """Conversion of each recorded column to a signal.

    Parameters
    ----------
    binding : Binding
        The twin.
    override : mapping of str to float
        Parameters given for the twin; a parameter may serve as a scale.
    """
    entries: dict[str, SignalEntry] = {**binding.file.inputs, **binding.file.outputs}
    return {
        name: SignalSpec(
            name=name,
            column=entry.column or name,
            scale=_scale(binding, entry, override),
            scaled=entry.scale is not None,
            offset=0.0 if entry.offset == "fit" else float(entry.offset),
            unit=binding.variables[entry.variable].variable.si_unit,
            interpolation=getattr(entry, "interpolation", "hold"),
            compared=name in binding.file.outputs,
            driven=name in binding.file.inputs,
        )
        for name, entry in entries.items()
    }


def input_columns(
    binding: Binding, recording: Recording, grid: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Signals of [inputs] that the recording holds, on the grid [SI].

    Parameters
    ----------
    binding : Binding
        The twin.
    recording : Recording
        Recording that is followed; an input that it lacks keeps the FMU's start value.
    grid : ndarray, shape (rows,)
        [s] Communication points.

    Raises
    ------
    RecordingError
        It holds none of the inputs, or an input with a wrong dimension or without values.
    """
    inputs = binding.file.inputs
    label = recording.name or "recording"
    present = [name for name in inputs if name in recording.signals]
    if inputs and not present:
        have = ", ".join(recording.signals) or "none"
        raise RecordingError(
            f"{label}: expected at least one signal of [inputs] ({', '.join(inputs)}) to drive "
            f"'{binding.file.name}', it holds {have}; 'gmfbo columns' maps its columns"
        )
    for name in present:
        _check_unit(binding, recording, name, label)
    return {
        name: sample(
            recording.time, recording.signals[name], grid, inputs[name].interpolation, name
        )
        for name in present
    }


def to_fmu(variable: FmuVariable, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values in SI, any shape, in the FMU's unit."""
    if variable.to_si == 1.0 and variable.si_zero == 0.0:
        return values
    return (values - variable.si_zero) / variable.to_si


def to_si(variable: FmuVariable, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values in the FMU's unit, any shape, in SI."""
    if variable.to_si == 1.0 and variable.si_zero == 0.0:
        return values
    return values * variable.to_si + variable.si_zero


def as_logged(entry: OutputEntry, column: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values that the logger stores at each communication point, shape (rows,).

    The FMU's output at t_k is the command still held there. A logger of kind `new` stores the
    command computed at t_k, which the FMU shows after the step from t_k: one row later. The last
    row repeats the one before, as its step is not simulated.

    Parameters
    ----------
    entry : OutputEntry
        Tells what the logger stores; held is assumed where unknown.
    column : ndarray, shape (rows,)
        FMU's output at the communication points.
    """
    if entry.logged != "new" or column.size < 2:
        return column
    return np.append(column[1:], column[-1])


def _scale(binding: Binding, entry: SignalEntry, override: Mapping[str, float]) -> float:
    if entry.scale is None:
        return 1.0
    if isinstance(entry.scale, str):
        return float(override.get(entry.scale, binding.nominal(entry.scale)))
    return float(entry.scale)


def _check_unit(binding: Binding, recording: Recording, name: str, label: str) -> None:
    stated = recording.units.get(name, "")
    expected = binding.variables[binding.file.inputs[name].variable].variable.si_unit
    came, wanted = parse_unit(stated), parse_unit(expected)
    if not stated or not expected or came is None or wanted is None:
        return
    if came.dimension != wanted.dimension and "1" not in (came.si, wanted.si):
        raise RecordingError(
            f"{label}: signal '{name}': expected {expected}, the unit of FMU input "
            f"'{binding.file.inputs[name].variable}', got {stated}"
        )
