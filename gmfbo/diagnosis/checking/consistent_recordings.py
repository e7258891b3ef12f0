"""Recordings as a diagnosis may use them: without contradiction to the twin or its controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.checking.column_quality import LAGS, exceeds_chance, misses_samples
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

    A logger that misses a sample writes the row before again, all of it, and no row farther before.
    One column alone may repeat as well at a limit, by the digits it is written with, or in a
    controller that is slower than the rows.
    """
    rows = [_repeated_whole(twin, recording) for recording in recordings]
    missed = sum(own.missed.size for own in rows)
    by_chance = max(sum(own.coincidences[lag] for own in rows) for lag in range(len(LAGS)))
    if not exceeds_chance(missed, by_chance) or not misses_samples(
        missed, sum(map(len, recordings))
    ):
        return tuple(recordings), []
    found = []
    for recording, own in zip(recordings, rows, strict=True):
        is_missed = np.isin(np.arange(len(recording)), own.missed)
        blanked = {n: np.where(is_missed, np.nan, recording.signal(n)) for n in own.outputs}
        found.append(recording.with_signals(blanked) if own.missed.size else recording)
    counts = [(r.name, own.missed.size) for r, own in zip(recordings, rows, strict=True)]
    return tuple(found), [_blanked([one for one in counts if one[1]])]


class _Repeated(NamedTuple):
    """Rows of a recording that repeat the one before, and how many repeat one farther before."""

    outputs: list[str]
    missed: NDArray[np.int64]
    coincidences: tuple[int, ...]


def _repeated_whole(twin: FmuTwin, recording: Recording) -> _Repeated:
    outputs = [n for n in twin.file.outputs if n in recording.signals.keys() - twin.file.inputs]
    columns = [recording.signal(name) for name in outputs]
    none = _Repeated([], np.zeros(0, dtype=np.int64), (0,) * len(LAGS))
    if len(columns) < 2 or min(np.isfinite(column).sum() for column in columns) < LEAST_ROWS:
        return none
    positions = describe_rig(twin.binding, outputs).positions
    each = [missed_samples(twin, positions, recording, name) for name in outputs]
    again = _repeats(columns, 1)
    missed = np.unique(np.concatenate(each))
    farther = (int(np.sum(_repeats(columns, lag) & ~again)) for lag in LAGS)
    return _Repeated(outputs, missed[again[missed]], tuple(farther))


def _repeats(columns: Sequence[NDArray[np.float64]], lag: int) -> NDArray[np.bool_]:
    """Whether all columns repeat what stands so many rows before."""
    found = np.zeros(columns[0].size, dtype=bool)
    found[lag:] = np.all([column[lag:] == column[:-lag] for column in columns], axis=0)
    return found


def _blanked(counts: Sequence[tuple[str, int]]) -> str:
    where = counts[0][0] if len(counts) == 1 else f"{len(counts)} recordings"
    return (
        f"{sum(missed for _, missed in counts)} rows in {where} repeat the one before while the "
        "axis moves: they were taken for blank"
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
