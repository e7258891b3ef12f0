"""Recorded commands that contradict the twin's controller, where no plant takes part."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.locating.parities import Parities
from gmfbo.errors import RecordingError
from gmfbo.sources.recorded.contradiction import Doubts, flipped, in_unit, unrelated
from gmfbo.sources.recorded.controlled_signal import controlled, reference_of
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
        seen = computed_command(case, checked, k)
        if seen is None:
            continue
        name = case.simulations.records[k].name
        told = _of_command(case.twin, name, command, seen)
        if not told and k in doubts.position and seen.near < MIDWAY:
            asked = reference_of(case.twin)
            told = unrelated(
                name, controlled(case.twin), asked, "nor is the command computed of it"
            )
        if told:
            raise RecordingError(told)


def computed_command(case: Case, checked: Parities, k: int) -> Likeness | None:
    """Likeness of a recorded command to what the twin's controller computes of the measurement.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    checked : Parities
        Runs of the twin that was held on its recordings.
    k : int
        Index of the recording.

    Returns
    -------
    Likeness or None
        None where the controller could not be checked, or one of the two does not move.
    """
    command = command_of(case)
    if checked.controller is None or command is None:
        return None
    record = case.simulations.records[k]
    signal = next(s for s in record.signals if s.name == command)
    computed = np.interp(signal.time, record.plan.grid, checked.held[k].response.held[command])
    return likeness(signal.values, computed)


def _of_command(twin: FmuTwin, name: str, command: str, seen: Likeness) -> str:
    against = "what the twin's controller computes from the recorded measurement"
    if seen.is_flipped:
        return flipped(name, command, against, seen.gain)
    if seen.correlation < SAME_SHAPE:
        return ""
    variables, file = twin.binding.variables, twin.file
    unit = mistaken_unit(variables[file.outputs[command].variable].variable.si_unit, seen.gain)
    return in_unit(name, command, against, seen.gain, unit) if unit is not None else ""
