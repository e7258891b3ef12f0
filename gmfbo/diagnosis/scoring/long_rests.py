"""Long rests, and such as a recording begins in: friction may hold an axis anywhere there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS, Record, ScoredSignal
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.noise_levels import SECOND_DIFFERENCE
from gmfbo.diagnosis.scoring.windows import SETTLING

Array = NDArray[np.float64]

_SLOWEST = 1e-4  # of the fastest motion of a twin, which has no noise
_DEVIATIONS = 5.0  # of noise: one in a million

Intervals = tuple[tuple[float, float], ...]


def mark_long_rests(
    simulations: Simulations, simulated: Sequence[Simulated], position: str | None, loop_time: float
) -> list[str]:
    """Mark in each record where it rests for long, as recorded and as its twin runs.

    Parameters
    ----------
    simulations : Simulations
        Whose records are marked.
    simulated : sequence of Simulated
        The recordings, as the twin runs.
    position : str or None
        Signal whose motion counts; without one nothing is marked.
    loop_time : float
        [s] Time constant of the closed loop.

    Returns
    -------
    list of str
        A note, where there is such a rest.
    """
    if simulations.tracking is not None or "torque" not in simulated[0].response.ports:
        return []  # no controller holds the twin, or nobody could ask whether one does
    pairs = list(zip(simulations.records, simulated, strict=True))
    moving = [_moving(record, run, position, loop_time) for record, run in pairs]
    fastest = max((m.simulated.max() for m in moving if m is not None), default=0.0)
    simulations.replace_records(
        [
            replace(record, rests=() if motion is None else motion.rests(fastest, loop_time))
            for (record, _), motion in zip(pairs, moving, strict=True)
        ]
    )
    seconds = sum(end - start for record in simulations.records for start, end in record.rests)
    if seconds == 0.0:
        return []
    return [
        f"long rests, {seconds:.3g} s, are compared while they settle, one in the first row "
        "not at all: friction may hold an axis anywhere, and noise lets it creep"
    ]


class _Motion:
    """Speeds of a position, as recorded and as simulated.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    recorded, simulated : ndarray, shape (n,)
        [SI/s] Amounts, of the mean over a loop time.
    noise : float
        [SI/s] Largest amount that noise or a count make of the recorded one.
    """

    def __init__(self, signal: ScoredSignal, values: Array, loop_time: float) -> None:
        rows = max(1, round(loop_time / signal.spacing))
        self.time = signal.time
        self.recorded = _speed(signal.values, rows, signal.spacing)
        self.simulated = _speed(values, rows, signal.spacing)
        white = float(np.median(np.abs(np.diff(signal.values, 2)))) / SECOND_DIFFERENCE
        largest = max(_DEVIATIONS * white * np.sqrt(2.0 / rows), signal.resolution)
        self.noise = largest / ((rows + 1) * signal.spacing)

    def rests(self, fastest: float, loop_time: float) -> Intervals:
        """[s] Begin and end of each long rest."""
        spacing = float(self.time[1] - self.time[0])
        least = max(LEAST_ROWS, round(SETTLING * loop_time / spacing))
        slowest = _SLOWEST * fastest
        stands = self.recorded <= max(slowest, self.noise)
        at_rest = stands & (self.simulated <= slowest)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], at_rest.astype(int), [0]])))
        found = []
        for first, behind in zip(edges[::2], edges[1::2], strict=True):
            # Friction holds the axis for longer than its twin.
            stuck = np.logical_and.accumulate(stands[behind : behind + least]).sum()
            # How it holds the axis in the first row came of what nobody recorded.
            begins = bool(stands[:behind].all())
            if behind - first >= (1 if begins else 3) * least:
                start = self.time[0 if begins else first]
                found.append((float(start), float(self.time[behind + stuck - 1])))
        return tuple(found)


def _moving(
    record: Record, simulated: Simulated, position: str | None, loop_time: float
) -> _Motion | None:
    for signal, values in zip(record.signals, simulated.signals, strict=True):
        if signal.name == position:
            return _Motion(signal, values, loop_time)
    return None


def _speed(values: Array, rows: int, spacing: float) -> Array:
    """Amount of the difference of means before and after each row, [SI/s]."""
    ends = values[:rows].mean(), values[-rows:].mean()
    padded = np.concatenate([np.full(rows, ends[0]), values, np.full(rows, ends[1])])
    sums = np.concatenate([[0.0], np.cumsum(padded)])
    means = (sums[rows:] - sums[:-rows]) / rows
    n = values.size
    speed: Array = np.abs(means[rows + 1 : rows + 1 + n] - means[:n]) / ((rows + 1) * spacing)
    return speed
