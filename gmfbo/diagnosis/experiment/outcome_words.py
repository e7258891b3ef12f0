"""Prediction of an experiment by a rival, in words and numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.menu_runs import as_records, playing
from gmfbo.diagnosis.result.predictions import said
from gmfbo.diagnosis.runs.measured_excitation import states_of
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.physics import States
from gmfbo.plain_words import words
from gmfbo.recordings.recording import Recording
from gmfbo.units import quantity

_SMOOTH_S = 0.01
_AFTER_S = 0.15  # after a reversal; a later instant is not called "after a reversal"
_FAST = 0.7  # of the highest speed

Column = NDArray[np.float64]


def predicted_outcomes(
    case: Case, recording: Recording, points: Mapping[str, Point]
) -> dict[str, str]:
    """Describe where each rival differs most from another: signal, time and size.

    Parameters
    ----------
    case : Case
        Noise and units of the signals.
    recording : Recording
        The reference that is played.
    points : mapping of str to Point
        Values of twin and physics under each rival.

    Returns
    -------
    dict of str to str
        By rival; empty where fewer than two can follow the reference.
    """
    (record,) = records = as_records(case, [recording])
    with playing(case, records):
        runs = case.simulations.run(list(points.values()))
    played = {name: run for name, (run,) in zip(points, runs, strict=True) if run.finite}
    if len(played) < 2:
        return {}
    return {name: _outcome(case, record, name, played) for name in played}


def _outcome(case: Case, record: Record, name: str, played: Mapping[str, Simulated]) -> str:
    own, signals = played[name], record.signals
    apart, other, i = max(
        (
            (_smooth(own.signals[i] - run.signals[i], signal.spacing), rival, i)
            for rival, run in played.items()
            if rival != name
            for i, signal in enumerate(signals)
        ),
        key=lambda one: float(np.abs(one[0]).max()) / case.noise[signals[one[2]].name].total,
    )
    row, signal = int(np.argmax(np.abs(apart))), signals[i]
    file = case.twin.file
    unit = case.twin.binding.variables[file.outputs[signal.name].variable].variable.si_unit
    value = float(_smooth(own.signals[i], signal.spacing)[row])
    above = "above" if apart[row] > 0.0 else "below"
    time = float(signal.time[row])
    return (
        f"the {words(signal.name)} is {quantity(value, unit)} at {time:.3f} s"
        f"{_when(states_of(own, record), time)}, {quantity(abs(float(apart[row])), unit)} {above} "
        f"{said(other)}"
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
