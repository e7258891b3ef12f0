"""Recorded commands that contradict the twin's controller, where no plant takes part."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.locating.parities import Parities
from gmfbo.errors import RecordingError
from gmfbo.plain_words import number
from gmfbo.sources.recorded.contradiction import (
    Doubts,
    controlled,
    flipped,
    in_unit,
    unit_of,
    unrelated,
)
from gmfbo.sources.recorded.likeness import MIDWAY, SAME_SHAPE, Likeness, likeness
from gmfbo.sources.recorded.mistaken_unit import mistaken_unit
from gmfbo.sources.twin.twin import FmuTwin


def refuse_columns(case: Case, checked: Parities, doubts: Doubts) -> None:
    """Compare recorded commands with those of the twin's controller on the recorded measurement.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    checked : Parities
        Runs of the twin that was held on its recordings.
    doubts : Doubts
        Recordings that are judged.

    Raises
    ------
    RecordingError
        A command has the opposite sign or is in another unit, or the measurement is not that of
        the axis which the command drove.
    """
    command = command_of(case)
    if checked.controller is None or command is None:
        return
    for k in sorted(doubts.position | doubts.command):
        record = case.simulations.records[k]
        signal = next(s for s in record.signals if s.name == command)
        computed = np.interp(signal.time, record.plan.grid, checked.held[k].response.held[command])
        seen = likeness(signal.values, computed)
        if seen is None:
            continue
        told = _of_command(case.twin, record.name, command, seen)
        if not told and k in doubts.position and seen.near < MIDWAY:
            told = unrelated(
                record.name, controlled(case.twin), "nor is the command computed of it"
            )
        if told:
            raise RecordingError(told)


def _of_command(twin: FmuTwin, name: str, command: str, seen: Likeness) -> str:
    against = "what the twin's controller computes from the recorded measurement"
    if seen.is_flipped:
        return flipped(name, command, against, seen.gain)
    if seen.correlation < SAME_SHAPE:
        return ""
    variables, file = twin.binding.variables, twin.file
    unit = mistaken_unit(variables[file.outputs[command].variable].variable.si_unit, seen.gain)
    if unit is not None:
        return in_unit(name, command, against, seen.gain, unit)
    signal = controlled(twin)
    if not signal:
        return ""
    # Reference and measurement in one wrong unit: the loop is right, and its command is small.
    other = mistaken_unit(unit_of(twin, signal), 1.0 / seen.gain)
    if other is None:
        return ""
    return (
        f"{name}: {command} is {number(seen.gain)} times {against}, as if reference and {signal} "
        f'were in {other}; state their unit in the header, "{signal} [{other}]", or correct them'
    )
