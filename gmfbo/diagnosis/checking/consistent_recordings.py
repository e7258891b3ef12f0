"""Recordings as a diagnosis may use them: without contradiction to the twin or its controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.checking.column_quality import misses_samples
from gmfbo.diagnosis.checking.contradicted_command import refuse_columns
from gmfbo.diagnosis.checking.contradicted_motion import judge_motions
from gmfbo.diagnosis.checking.nominal_case import open_nominal
from gmfbo.diagnosis.checking.recording_facts import missed_samples
from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS
from gmfbo.diagnosis.scoring.signal_parts import describe_rig
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import Doubts
from gmfbo.sources.recorded.still_signals import still_lines
from gmfbo.sources.recorded.usable import Usable, usable
from gmfbo.sources.twin.twin import FmuTwin


def consistent(
    twin: FmuTwin, recordings: Sequence[Recording], *, seed: int, jobs: int | None
) -> Usable:
    """Unwrap angles, blank missed samples, and refuse recordings that contradict the twin.

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
    whole, missed = without_missed(twin, given.recordings)
    given = replace(given, recordings=whole, notes=(*given.notes, *still, *missed, *notes))
    if given.doubts.position or given.doubts.command:
        _ask_the_controller(twin, given.recordings, given.doubts, seed, jobs)
    return given


def without_missed(
    twin: FmuTwin, recordings: Sequence[Recording]
) -> tuple[tuple[Recording, ...], list[str]]:
    """Recordings whose missed samples are blank, and a remark on how many there are.

    A logger that misses a sample writes the row before again, all of it. One column alone may
    repeat as well at a limit, by the digits it is written with, or in a controller that is slower
    than the rows.
    """
    found, counts = [], list[tuple[str, int, int]]()
    for recording in recordings:
        outputs = [n for n in twin.file.outputs if n in recording.signals.keys() - twin.file.inputs]
        columns = {n: recording.signal(n) for n in outputs}
        if len(columns) < 2 or min(np.isfinite(c).sum() for c in columns.values()) < LEAST_ROWS:
            found.append(recording)
            continue
        again = np.all([np.diff(c, prepend=np.nan) == 0.0 for c in columns.values()], axis=0)
        positions = describe_rig(twin.binding, outputs).positions
        missed = np.unique(
            np.concatenate([missed_samples(twin, positions, recording, n) for n in outputs])
        )
        missed = missed[again[missed]]
        if not misses_samples(missed.size, again.size):
            found.append(recording)
            continue
        counts.append((recording.name, missed.size, again.size))
        is_missed = np.isin(np.arange(again.size), missed)
        blanked = {n: np.where(is_missed, np.nan, column) for n, column in columns.items()}
        found.append(recording.with_signals(blanked))
    return tuple(found), [_blanked(counts)] if counts else []


def _blanked(counts: Sequence[tuple[str, int, int]]) -> str:
    where = counts[0][0] if len(counts) == 1 else f"{len(counts)} recordings"
    missed, rows = (sum(column) for column in list(zip(*counts, strict=True))[1:])
    return (
        f"{missed} of {rows} rows in {where} repeat the one before while the axis moves: they were "
        "taken for blank"
    )


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
