"""Prediction of an experiment by a rival, in words and numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.menu_runs import Played
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.physics import States
from gmfbo.plain_words import words
from gmfbo.units import quantity

_SMOOTH_S = 0.01
_AFTER_S = 0.15  # after a reversal; a later instant is not called "after a reversal"
_FAST = 0.7  # of the highest speed

Column = NDArray[np.float64]


def predicted_outcome(
    case: Case, record: Record, name: str, entry: int, runs: Mapping[str, Played]
) -> str:
    """Describe where a rival differs most from another: signal, time and size.

    Parameters
    ----------
    case : Case
        Noise and units of the signals.
    record : Record
        The reference that is played.
    name : str
        The rival.
    entry : int
        Place of the reference on the menu.
    runs : mapping of str to Played
        All rivals.
    """
    own = runs[name].simulated[entry]
    largest: tuple[float, str, int, int] | None = None
    for other, played in runs.items():
        if other == name:
            continue
        for i, signal in enumerate(record.signals):
            apart = _smooth(own.signals[i] - played.simulated[entry].signals[i], signal.spacing)
            row = int(np.argmax(np.abs(apart)))
            size = float(np.abs(apart[row])) / case.noise[signal.name].total
            if largest is None or size > largest[0]:
                largest = (size, other, i, row)
    assert largest is not None, "there are at least two rivals"
    _, other, i, row = largest
    signal = record.signals[i]
    apart = _smooth(own.signals[i] - runs[other].simulated[entry].signals[i], signal.spacing)
    file = case.twin.file
    unit = case.twin.binding.variables[file.outputs[signal.name].variable].variable.si_unit
    value = float(_smooth(own.signals[i], signal.spacing)[row])
    above = "above" if apart[row] > 0.0 else "below"
    time = float(signal.time[row])
    return (
        f"the {words(signal.name)} is {quantity(value, unit)} at {time:.3f} s"
        f"{_when(states_of(own, record), time)}, {quantity(abs(float(apart[row])), unit)} {above} "
        f"{words(other)}"
    )


def _smooth(column: Column, spacing: float) -> Column:
    rows = max(1, round(_SMOOTH_S / spacing))
    padded = np.pad(column, (rows // 2, rows - 1 - rows // 2), mode="edge")
    return np.asarray(np.convolve(padded, np.ones(rows) / rows, mode="valid"))


def _when(states: States, time: float) -> str:
    """Words for what the axis does at a time [s]."""
    row = int(np.searchsorted(states.time, time))
    row = min(row, states.time.size - 1)
    moving = np.flatnonzero(np.abs(states.velocity[: row + 1]) > states.rest)
    signs = np.sign(states.velocity[moving])
    turns = moving[1:][signs[1:] != signs[:-1]]
    if turns.size and time - states.time[turns[-1]] < _AFTER_S:
        return f", {quantity(float(time - states.time[turns[-1]]), 's')} after a reversal"
    speed = abs(float(states.velocity[row]))
    if speed <= states.rest:
        return ", at rest"
    return ", at high speed" if speed > _FAST * np.abs(states.velocity).max() else ""
