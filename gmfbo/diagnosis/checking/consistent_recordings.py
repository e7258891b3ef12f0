"""Recordings as a diagnosis may use them: unwrapped, and without contradiction to the twin."""

from __future__ import annotations

from collections.abc import Sequence

from gmfbo.diagnosis.checking.contradiction import Doubts, refuse_columns, refuse_contradictions
from gmfbo.diagnosis.checking.missing_signals import missing_signals
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.diagnosis.checking.wrapped_angle import unwrapped
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin


def whole_angles(
    twin: FmuTwin, recordings: Sequence[Recording]
) -> tuple[list[Recording], list[str]]:
    """Unwrap the angles of all recordings.

    Parameters
    ----------
    twin : FmuTwin
        Tells which signals are angles.
    recordings : sequence of Recording
        As they were read.

    Returns
    -------
    tuple of list of Recording and list of str
        The recordings, and what was changed in them.
    """
    changed = [unwrapped(recording, twin) for recording in recordings]
    return [recording for recording, _ in changed], [n for _, notes in changed for n in notes]


def consistent(
    twin: FmuTwin, recordings: Sequence[Recording], *, seed: int, jobs: int | None
) -> tuple[list[Recording], list[str]]:
    """Unwrap angles, note what is missing, and refuse recordings that contradict the twin.

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
    tuple of list of Recording and list of str
        The recordings to use, and notes for the reader.

    Raises
    ------
    RecordingError
        A recording contradicts the twin; one line says how.
    SimulationError
        The twin as it is cannot follow the recordings.
    """
    whole, notes = whole_angles(twin, recordings)
    doubts = refuse_contradictions(twin, whole)
    if doubts:
        _ask_the_controller(twin, whole, doubts, seed, jobs)
    missing = [f"{m.recording}: {m.what}: {m.without}" for m in missing_signals(twin, whole)]
    return whole, notes + missing


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
