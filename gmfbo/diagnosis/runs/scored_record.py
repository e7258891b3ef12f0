"""Scored records: recordings as uniform columns of the signals that the twin outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.errors import RecordingError
from gmfbo.objective.fit import scored_rows
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import RunPlan

_JITTER_SHARE = 0.15  # of a sample; below it, times count as evenly spaced
_GAP_SAMPLES = 4.5  # beyond which interpolation between the neighbouring rows is meaningless
LEAST_ROWS = 64
"""Fewest samples of a signal that can be scored."""


@dataclass(frozen=True, eq=False)
class ScoredSignal:
    """One signal of one recording on evenly spaced times.

    Attributes
    ----------
    name : str
        As the twin file calls it.
    time : ndarray, shape (n,)
        [s]
    values : ndarray, shape (n,)
        [SI] As recorded.
    resolution : float
        [SI] Smallest step between recorded values; 0 where they are continuous.
    driving : ndarray, shape (n,), or None
        Scored part of the signal, where a tracking loop removes the rest.
    stamps : ndarray, shape (n,), or None
        [s] Times as the logger wrote them, from which the values were put on these; None where
        rows are lost.
    """

    name: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    resolution: float
    driving: NDArray[np.float64] | None = None
    stamps: NDArray[np.float64] | None = None

    @property
    def spacing(self) -> float:
        """[s] Between samples."""
        return float(self.time[-1] - self.time[0]) / (self.time.size - 1)


@dataclass(frozen=True)
class Gap:
    """A stretch within which a logger lost more than single rows.

    Attributes
    ----------
    start, end : float
        [s] Last row before it and first row after it.
    of_input : bool
        Whether an input is missing: the axis then has to settle before it is scored again.
    """

    start: float
    end: float
    of_input: bool


@dataclass(frozen=True, eq=False)
class Record:
    """A recording that is scored.

    Attributes
    ----------
    name : str
        Of its file.
    plan : RunPlan
        Plan of its simulation.
    signals : tuple of ScoredSignal
        Signals that are compared with the twin's outputs.
    start, end : float
        [s] Times between which all signals are scored.
    gaps : tuple of Gap
        Stretches with missing values.
    rests : tuple of (float, float)
        [s] Long rests, in which friction may hold the axis anywhere.
    """

    name: str
    plan: RunPlan
    signals: tuple[ScoredSignal, ...]
    start: float
    end: float
    gaps: tuple[Gap, ...] = ()
    rests: tuple[tuple[float, float], ...] = ()

    def stretches(self, settling: float, *, starts_elsewhere: bool) -> list[tuple[float, float]]:
        """[s] Begin and end of each stretch that can be scored.

        Parameters
        ----------
        settling : float
            [s] Time after which the axis' initial state no longer matters.
        starts_elsewhere : bool
            Whether the twin starts in another state than the recording.
        """
        begin = self.start + (settling if starts_elsewhere else 0.0)
        found = []
        for gap in sorted(self.gaps, key=lambda g: g.start):
            found.append((begin, gap.start))
            begin = max(begin, gap.end + (settling if gap.of_input else 0.0))
        found.append((begin, self.end))
        return [(a, b) for a, b in found if b > a]


def with_same_gains(records: Sequence[Record]) -> list[list[int]]:
    """Recordings in groups in which the loop is the same; one whose gains change is alone.

    Parameters
    ----------
    records : sequence of Record
        Of one twin.

    Returns
    -------
    list of list of int
        Their indices.
    """
    groups: dict[object, list[int]] = {}
    for k, record in enumerate(records):
        plan = record.plan
        gains = tuple(sorted(plan.experiment.parameters.in_force.items()))
        groups.setdefault(k if plan.schedules.shape[1] else gains, []).append(k)
    return list(groups.values())


def scored_record(
    recording: Recording, plan: RunPlan, signals: Sequence[str], warmup: float
) -> Record:
    """Make the scored record of a recording.

    Parameters
    ----------
    recording : Recording
        As it was read.
    plan : RunPlan
        Of the same recording.
    signals : sequence of str
        Outputs of the twin; those that the recording lacks are left out.
    warmup : float
        [s] From the first row: simulated but not scored.

    Raises
    ------
    RecordingError
        Nothing is left to score.
    """
    label = recording.name or "recording"
    present = [
        name
        for name in signals
        if name in recording.signals
        and scored_rows(recording, name, warmup=warmup).sum() >= LEAST_ROWS
    ]
    if not present:
        raise RecordingError(
            f"{label}: expected at least {LEAST_ROWS} rows of one of {', '.join(signals)} to "
            f"compare with the twin, it holds {', '.join(recording.signals) or 'no signal'}"
        )
    rows = {name: scored_rows(recording, name, warmup=warmup) for name in present}
    start = max(float(recording.time[r][0]) for r in rows.values())
    end = min(float(recording.time[r][-1]) for r in rows.values())
    cut = tuple(_uniform(name, recording, rows[name], start, end) for name in present)
    gaps = [g for r in rows.values() for g in _gaps(recording.time[r], of_input=False)]
    for name in plan.experiment.inputs:
        if name in recording.signals:
            known = np.isfinite(recording.signal(name))
            gaps += _gaps(recording.time[known], of_input=True)
    inside = tuple(g for g in gaps if g.end > start and g.start < end)
    return Record(label, plan, cut, start, end, inside)


def _even(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Evenly spaced times from the first to the last, one for each row and each dropped one."""
    steps = np.diff(time)
    # Counted row by row: an error of 0.5 % in the median step would add a row in 200.
    places = np.round(steps / np.median(steps)).clip(1.0).sum()
    return np.linspace(time[0], time[-1], int(places) + 1)


def _gaps(time: NDArray[np.float64], *, of_input: bool) -> list[Gap]:
    if time.size < 3:
        return []
    steps = np.diff(time)
    wide = np.flatnonzero(steps > _GAP_SAMPLES * np.median(steps))
    return [Gap(float(time[i]), float(time[i + 1]), of_input) for i in wide]


def _uniform(
    name: str, recording: Recording, rows: NDArray[np.bool_], start: float, end: float
) -> ScoredSignal:
    slack = 1e-9 * max(1.0, abs(end))
    inside = rows & (recording.time >= start - slack) & (recording.time <= end + slack)
    time, values = recording.time[inside], recording.signal(name)[inside]
    even = _even(time)
    spacing = float(even[1] - even[0])
    stamps = time if even.size == time.size else None
    if even.size != time.size or np.abs(even - time).max() > _JITTER_SHARE * spacing:
        values = np.interp(even, time, values)
        time = even
    return ScoredSignal(name, time, values, resolution(values), stamps=stamps)


def means_over_rows(
    plan: RunPlan, means: NDArray[np.float64], time: NDArray[np.float64]
) -> NDArray[np.float64]:
    """A column as a logger stores it that averages since its row before, shape (n,).

    Parameters
    ----------
    plan : RunPlan
        With the steps of the simulation.
    means : ndarray, shape (rows,)
        The column, averaged since the step before.
    time : ndarray, shape (n,)
        [s] Of the logger's rows.
    """
    if time.size < 2:
        return plan.at(means, time)
    since = np.concatenate([[0.0], np.cumsum(means[1:] * np.diff(plan.grid))])
    rows = np.diff(np.interp(time, plan.grid, since)) / np.diff(time)
    return np.concatenate([plan.at(means, time[:1]), rows])
