"""Join samples at which a mismatch shows into a few stretches of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.result.whereabouts import TimeWindow

MOST_WINDOWS = 12
_PER_RECORDING = 3
_JOINED_S = 0.03  # a shorter pause between two stretches is none
_LEAST_S = 0.02
_LONG_S = 0.3  # a longer stretch is cut into parts where its weight lies
_HEAVY = 0.25  # of the largest weight in a long stretch
_WEAK = 0.05  # of the strongest stretch's weight: weaker ones are left out

Column = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Stretch:
    """A stretch of one recording, and how strongly the mismatch shows there.

    Attributes
    ----------
    record : int
        Index of the recording.
    start, end : float
        [s]
    weight : float
        Sum of squares of the mismatch, or number of moving rows in `moving_parts`.
    """

    record: int
    start: float
    end: float
    weight: float


def strongest(
    grids: Sequence[Column], masks: Sequence[Mask], weights: Sequence[Column], most: int
) -> list[Stretch]:
    """Find the strongest stretches, a few of each recording.

    Parameters
    ----------
    grids : sequence of ndarray, shape (rows,)
        [s]
    masks : sequence of ndarray of bool, shape (rows,)
        Where stretches may lie.
    weights : sequence of ndarray, shape (rows,)
        Square of the mismatch.
    most : int
        Stretches at most.
    """
    found: list[Stretch] = []
    for k, (grid, mask, weight) in enumerate(zip(grids, masks, weights, strict=True)):
        own = [_stretch(k, grid, weight, *run) for run in _short_runs(grid, mask, weight)]
        found += sorted(own, key=lambda s: -s.weight)[:_PER_RECORDING]
    found.sort(key=lambda s: -s.weight)
    return [s for s in found[:most] if s.weight > _WEAK * found[0].weight]


def moving_parts(grids: Sequence[Column], masks: Sequence[Mask]) -> list[Stretch]:
    """Stretch of each recording from its first to its last motion, most motion first.

    Parameters
    ----------
    grids : sequence of ndarray, shape (rows,)
        [s]
    masks : sequence of ndarray of bool, shape (rows,)
        Where something moves.
    """
    parts = []
    for k, (grid, mask) in enumerate(zip(grids, masks, strict=True)):
        rows = np.flatnonzero(mask)
        if rows.size:
            parts.append(Stretch(k, float(grid[rows[0]]), float(grid[rows[-1]]), float(rows.size)))
    return sorted(parts, key=lambda s: -s.weight)


def time_windows(stretches: Sequence[Stretch], names: Sequence[str]) -> tuple[TimeWindow, ...]:
    """Join stretches that overlap and put all in order."""
    joined: list[tuple[int, float, float]] = []
    for s in sorted(stretches, key=lambda s: (s.record, s.start)):
        if joined and joined[-1][0] == s.record and s.start <= joined[-1][2]:
            record, start, end = joined.pop()
            joined.append((record, start, max(end, s.end)))
        else:
            joined.append((s.record, s.start, s.end))
    return tuple(TimeWindow(names[k], round(a, 6), round(b, 6)) for k, a, b in joined)


def smeared(grid: Column, weight: Column, after_s: float) -> Column:
    """Mean of a weight over the time that follows each row, since a cause precedes its effect."""
    rows = max(1, round(after_s / float(grid[1] - grid[0])))
    total = np.concatenate([[0.0], np.cumsum(np.append(weight, np.zeros(rows)))])
    return np.asarray((total[rows : rows + weight.size] - total[: weight.size]) / rows)


def _runs(grid: Column, mask: Mask) -> list[tuple[int, int]]:
    """First and last row of each run of True, short pauses bridged."""
    rows = np.flatnonzero(mask)
    if not rows.size:
        return []
    pause = max(1, round(_JOINED_S / float(grid[1] - grid[0])))
    breaks = np.flatnonzero(np.diff(rows) > pause)
    firsts = rows[np.concatenate([[0], breaks + 1])]
    lasts = rows[np.concatenate([breaks, [rows.size - 1]])]
    return [(int(a), int(b)) for a, b in zip(firsts, lasts, strict=True)]


def _short_runs(grid: Column, mask: Mask, weight: Column) -> list[tuple[int, int]]:
    """Runs of True; a long run is replaced by its heavy parts."""
    short: list[tuple[int, int]] = []
    for first, last in _runs(grid, mask):
        if grid[last] - grid[first] <= _LONG_S:
            short.append((first, last))
            continue
        inside = weight[first : last + 1]
        heavy = np.zeros_like(mask)
        heavy[first : last + 1] = inside >= _HEAVY * inside.max()
        short += _runs(grid, heavy)
    return short


def _stretch(k: int, grid: Column, weight: Column, first: int, last: int) -> Stretch:
    """Stretch of a run, lengthened where it is too short to see."""
    total = float(weight[first : last + 1].sum())
    missing = max(0.0, _LEAST_S - float(grid[last] - grid[first]))
    start = max(float(grid[0]), float(grid[first]) - 0.5 * missing)
    end = min(float(grid[-1]), float(grid[last]) + 0.5 * missing)
    return Stretch(k, start, end, total)
