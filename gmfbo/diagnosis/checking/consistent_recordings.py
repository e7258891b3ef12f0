"""Recordings as a diagnosis may use them: without contradiction to the twin or its controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gmfbo.diagnosis.checking.contradicted_command import refuse_columns
from gmfbo.diagnosis.checking.contradicted_motion import judge_motions
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import Doubts
from gmfbo.sources.recorded.still_signals import still_lines
from gmfbo.sources.recorded.usable import Usable, usable
from gmfbo.sources.twin.twin import FmuTwin


def consistent(
    twin: FmuTwin, recordings: Sequence[Recording], *, seed: int, jobs: int | None
) -> Usable:
    """Unwrap angles, name what is missing, and refuse recordings that contradict the twin.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        As they were read.
    seed : int
        Of the noise runs.
    jobs : int or None
        Simulators; None for one a processor.

    Returns
    -------
    Usable
        The recordings to use, and what there is to tell about them.

    Raises
    ------
    RecordingError
        A recording contradicts the twin; one line says how.
    SimulationError
        The twin as it is cannot follow the recordings.
    """
    given = usable(twin, recordings)
    notes = judge_motions(twin, given.recordings, given.doubts, seed=seed, jobs=jobs)
    still = [line for recording in given.recordings for line in still_lines(twin, recording)]
    given = replace(given, notes=(*given.notes, *still, *notes))
    if given.doubts.position or given.doubts.command:
        _ask_the_controller(twin, given.recordings, given.doubts, seed, jobs)
    return given


def _ask_the_controller(
    twin: FmuTwin, recordings: Sequence[Recording], doubts: Doubts, seed: int, jobs: int | None
) -> None:
    if "sensor" not in twin.file.ports or "command" not in twin.file.states:
        return
    nominal = open_nominal(twin, recordings, seed=seed, jobs=jobs, on_run=lambda: None)
    try:
        refuse_columns(nominal.case, nominal.checked, doubts)
    finally:
        nominal.case.simulations.close()
