"""Recordings whose motion is in another unit, by the twin's controller and without a plant."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gmfbo.diagnosis.case.command_signal import command_of
from gmfbo.diagnosis.checking.contradicted_command import computed_command
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.errors import RecordingError, SimulationError
from gmfbo.plain_words import listed
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import Doubts
from gmfbo.sources.recorded.likeness import SAME_SHAPE
from gmfbo.sources.recorded.mistaken_unit import AXIS_GAIN
from gmfbo.sources.recorded.motion_unit import MotionUnit
from gmfbo.sources.twin.twin import FmuTwin


def judge_motions(
    twin: FmuTwin, recordings: Sequence[Recording], doubts: Doubts, *, seed: int, jobs: int | None
) -> list[str]:
    """Let the twin's controller compute the recorded command of the motion in the other unit.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        As they were read.
    doubts : Doubts
        Recordings that are judged, with the other unit.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.

    Returns
    -------
    list of str
        A note for each recording whose motion seems to be in another unit, where the twin's
        controller cannot be asked.

    Raises
    ------
    RecordingError
        Only in the other unit does the controller compute the recorded command; or what else
        contradicts the twin.
    """
    notes = []
    for k, moved in doubts.motion.items():
        name = recordings[k].name or "recording"
        computes = _computes_command(twin, moved.recording, seed, jobs)
        if computes and not _computes_command(twin, recordings[k], seed, jobs):
            raise RecordingError(_refusal(twin, name, moved))
        if computes is None and moved.is_beyond_physics:
            if k in doubts.otherwise:
                raise RecordingError(moved.told(name))
            notes.append(moved.told(name))
        elif k in doubts.otherwise:
            raise RecordingError(doubts.otherwise[k])
    return notes


def _computes_command(
    twin: FmuTwin, recording: Recording, seed: int, jobs: int | None
) -> bool | None:
    """Whether the controller computes the recorded command; None where it cannot be asked."""
    if "sensor" not in twin.file.ports or "command" not in twin.file.states:
        return None
    try:
        nominal = open_nominal(twin, [recording], seed=seed, jobs=jobs, on_run=lambda: None)
    except SimulationError:
        return None
    try:
        if nominal.checked.controller is None or command_of(nominal.case) is None:
            return None
        if not nominal.checked.controller.fails:
            return True
        seen = computed_command(nominal.case, nominal.checked, 0)
    finally:
        nominal.case.simulations.close()
    if seen is None or seen.correlation < SAME_SHAPE:
        return False
    return abs(math.log(seen.gain)) <= math.log(AXIS_GAIN)


def _refusal(twin: FmuTwin, name: str, moved: MotionUnit) -> str:
    file = twin.file
    command = next(n for n, e in file.outputs.items() if e.variable == file.states["command"])
    return (
        f"{name}: the twin's controller computes the recorded {command} only as if "
        f"{listed(moved.names)} were in {moved.unit}; {moved.cure()}"
    )
