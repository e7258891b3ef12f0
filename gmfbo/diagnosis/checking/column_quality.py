"""Faults of logging: repeats, latches, clipping and lost rows of columns, and uneven clocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter

from gmfbo.diagnosis.checking.result import ClockQuality
from gmfbo.diagnosis.runs.quantum import resolution
from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS
from gmfbo.diagnosis.scoring.noise_levels import fast_power

Array = NDArray[np.float64]

LAGS = (2, 3)
"""[rows] At which a repeat is chance; after more, a drift has gone on."""

_AROUND = 11  # rows whose median gives the usual step around a row
_LEAST_REPEATS = 3
_REPEATED_SHARE = 1e-3
_QUANTA = 3.0  # usual step in quanta, above which a repeat is no slow motion
_LATER = 2  # rows after a reading in which a command shows it: held for a row, and of a rate
_NOISE_FREE = 0.1  # of the usual step: less noise does not hide whether a signal catches up
_CHANCE = 4.0  # standard deviations of the number of repeats that rounding makes
_LATCHED = 1.8  # rows for which a value stays: above it, the column is sampled more slowly
_REST_ROWS = 50  # a value that stays longer is rest, not a latch
_CLIPPED_ROWS = 3  # of a stretch at the extreme value
_OWN_CHANGES = 0.95  # quantile of an axis' changes of speed, up to which it may stop by itself
_CLIPPED_ENTRY = 1e-3  # of the range, by which a signal runs into its limit in one row
_STEADY_LEAST = 0.05  # of the highest speed, above which an axis moves
_STEADY_CHANGE = 0.02  # of the speed, between the halves of a stretch at steady speed
_JUMP = (1.5, 20.0)  # step over its neighbours' where rows are lost
_JUMP_SPREADS = 6.0  # of all steps beside their neighbours'
_JUMP_SHARE = 0.2  # of the fastest step: a lost row at standstill shows nothing
_MOVING = 0.1  # of the least jump: a signal with larger usual steps would have to jump too
_ALIKE = 0.3  # by which two columns may differ in how many rows they miss


def refresh_rows(values: Array, quantum: float) -> float:
    """Rows for which a value stays the same on average, while the signal moves.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    quantum : float
        Resolution; 0 for continuous values.

    Returns
    -------
    float
        1 where each row is a new sample, or where the resolution hides it.
    """
    steps = np.abs(np.diff(values))
    moving = steps[steps > 0.0]
    if moving.size < 10 or float(np.median(moving)) <= _QUANTA * quantum:
        return 1.0
    changes = np.flatnonzero(steps)
    lengths = np.diff(changes)
    # An axis at rest repeats its reading, but for a count up or down: that is no hold.
    is_moving = steps[changes] > _QUANTA * quantum
    own = lengths[(lengths <= _REST_ROWS) & is_moving[:-1] & is_moving[1:]]
    # Of values that are held for 1.8 rows, one in five changes again in the next row.
    if not own.size or np.mean(own == 1) > 2.0 - _LATCHED:
        return 1.0
    return float(np.mean(own))


def repeated_rows(
    values: Array, quantum: float, left_out: NDArray[np.bool_] | None = None
) -> NDArray[np.int64]:
    """Rows that repeat the one before although the signal moves by more than its resolution.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    quantum : float
        Resolution; 0 for continuous values.
    left_out : ndarray of bool, shape (n,), optional
        Rows in which a repeat is no fault.
    """
    signed = np.diff(values)
    steps = np.abs(signed)
    usual = median_filter(steps, _AROUND, mode="nearest")
    inside = (values[1:] < values.max()) & (values[1:] > values.min())
    if left_out is not None:
        inside &= ~left_out[1:]
    still = (steps == 0.0) & inside
    if not quantum and _come_back(values) >= max(1, int(np.count_nonzero(still & (usual > 0.0)))):
        quantum = float(steps[steps > 0.0].min())
    moving = usual > _QUANTA * quantum
    rows: NDArray[np.int64] = np.flatnonzero(still & moving) + 1
    coincidences = _coincidences(values, moving & inside)
    if quantum or coincidences:
        chance = _chance_of_repeat(signed, quantum)
        by_chance = max(float(np.sum(chance[moving & inside])), coincidences)
        if not exceeds_chance(rows.size, by_chance):
            # Where the axis passes many counts a row, one repeat in the whole column is no chance.
            is_sure = (chance[rows - 1] < 1.0 / values.size) & (not coincidences)
            rows = rows[is_sure]
    sticking = _sticking(steps, usual, float(np.sqrt(fast_power(values))))
    return rows[~sticking[rows - 1]]


def exceeds_chance(repeated: int, by_chance: float) -> bool:
    """Whether so many rows repeat that chance, which makes `by_chance` of them, hardly could."""
    return bool(repeated > by_chance + _CHANCE * np.sqrt(by_chance + 1.0))


def misses_samples(repeated: int, rows: int) -> bool:
    """Whether so many repeats in so many rows are told as a fault of the logger."""
    return repeated >= _LEAST_REPEATS and repeated > _REPEATED_SHARE * rows


def _chance_of_repeat(steps: Array, quantum: float) -> Array:
    """Probability that a row rounds to the value of the row before, shape (n - 1,).

    A step repeats if it is within a quantum of zero, with a probability that falls from one to
    zero with its size: a triangle as wide as a normal density of variance quantum^2 / 6. Motion
    and noise of the steps around a row make the density of its step.
    """
    if not quantum:
        return np.zeros(steps.size)
    motion = median_filter(steps, _AROUND, mode="nearest")
    spread = 1.4826 * median_filter(np.abs(steps - motion), _AROUND, mode="nearest")
    variance = np.maximum(spread**2, quantum**2 / 6.0)  # recorded steps hold their rounding
    density = np.exp(-0.5 * motion**2 / variance) / np.sqrt(2.0 * np.pi * variance)
    return np.asarray(np.minimum(1.0, quantum * density), dtype=np.float64)


def _coincidences(values: Array, judged: NDArray[np.bool_]) -> float:
    """Rows that chance lets repeat the one before: as many as repeat one farther before.

    What is computed from counts has few values, though the column that holds them is fine. A
    logger that misses a sample repeats the row before, and no other.
    """
    counts = []
    for lag in LAGS:
        changed = judged[lag - 1 :] & (np.diff(values)[lag - 1 :] != 0.0)
        counts.append(np.count_nonzero((values[lag:] == values[:-lag]) & changed))
    return float(max(counts))


def near_rounding(
    times: Array, readings: Array, values: Array, quantum: float, asked: Array | None = None
) -> NDArray[np.bool_]:
    """Rows in which a reading may repeat by its rounding, and what is computed from it as well.

    Parameters
    ----------
    times : ndarray, shape (n,)
        [s] Of the rows of the computed signal.
    readings : ndarray, shape (m,)
        [s] Of the rows of the reading.
    values : ndarray, shape (m,)
        Reading.
    quantum : float
        Its resolution.
    asked : ndarray, shape (m,), optional
        Reference of the reading: where their difference repeats, so may what is computed from it.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    steps = np.diff(values)
    slow = median_filter(np.abs(steps), _AROUND, mode="nearest") <= _QUANTA * quantum
    repeats = steps == 0.0
    if asked is not None:
        repeats |= np.abs(np.diff(asked) - steps) < 0.5 * quantum
    repeats[repeated_rows(values, quantum) - 1] = False
    rounded = np.concatenate([[False], slow | repeats])
    # A command that is held shows a row later what it is computed from, a rate a row after that.
    rounded = maximum_filter1d(rounded, 2 * _LATER + 1)
    nearest = np.interp(times, readings, np.arange(readings.size))
    return np.asarray(rounded[np.round(nearest).astype(int)], dtype=np.bool_)


def _sticking(steps: Array, usual: Array, noise: float) -> NDArray[np.bool_]:
    """Steps of zero after which the signal does not catch up, shape (n - 1,): the axis stood still.

    The step after r repeated readings of a moving axis is r + 1 steps long. Where noise is as
    large as the steps, a reading that is exactly the same is a repeat.
    """
    still = np.concatenate([[False], steps == 0.0, [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    found = np.zeros(steps.size, dtype=bool)
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        after = steps[end] if end < steps.size else 0.0
        caught_up = 0.5 * (1.0 + (end - start + 1.0)) * usual[start:end]
        found[start:end] = (noise < _NOISE_FREE * usual[start:end]) & (after < caught_up)
    return found


def _come_back(values: Array) -> int:
    """Times at which a value is read again after another one: of a continuous signal, never."""
    changed = values[np.concatenate([[True], np.diff(values) != 0.0])]
    return int(changed.size - np.unique(changed).size)


def is_latched(refresh: float) -> bool:
    """Whether a column was sampled more slowly than it was logged."""
    return refresh > _LATCHED


def usual_noise(values: Array) -> float:
    """Standard deviation of white noise in most stretches of a column.

    A step of the reference is as fast as noise, and in a few stretches alone. A stretch in which
    the column stands still tells of no noise.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    """
    count = max(1, values.size // LEAST_ROWS)
    powers = [fast_power(stretch) for stretch in np.array_split(values, count)]
    told = [power for power in powers if power > 0.0]
    return float(np.sqrt(np.median(told))) if told else 0.0


def clipped_rows(
    values: Array, quantum: float, speed: Array | None = None, *, is_position: bool = False
) -> int:
    """Rows at an extreme value into which the signal runs without slowing down.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    quantum : float
        Resolution; 0 for continuous values.
    speed : ndarray, shape (n,), optional
        [position's unit / s] Of the axis; a value that goes with a steady speed is no limit.
    is_position : bool
        Whether an axis moves by these values: it slows down, and may stick where it turns.
    """
    entry = max(_QUANTA * quantum, _CLIPPED_ENTRY * float(np.ptp(values)))
    if is_position:
        entry = max(entry, _own_change(values))
    total = 0
    for side in (values, -values):
        at = np.concatenate([[False], side >= side.max() - 0.5 * quantum, [False]])
        edges = np.flatnonzero(np.diff(at.astype(int)))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            long_enough = end - start >= _CLIPPED_ROWS
            # The last step is cut short by the limit; the one before it is whole.
            if not long_enough or start <= 1:
                continue
            enters = np.diff(side[start - 2 : start + 1]).max() > entry
            if enters and not (speed is not None and _is_steady(speed, start, end)):
                total += int(end - start)
    return total


def _own_change(values: Array) -> float:
    """Change of step from row to row that a moving axis makes by itself: one row in twenty."""
    changes = np.abs(np.diff(values, 2))
    low, high = float(values.min()), float(values.max())
    away = (values[1:-1] > low) & (values[1:-1] < high)
    return float(np.quantile(changes[away], _OWN_CHANGES)) if away.any() else 0.0


def _is_steady(speed: Array, start: int, end: int) -> bool:
    """Whether an axis moves at one speed over these rows: what it needs for that is no limit."""
    middle = (start + end + 1) // 2
    first, last = float(np.mean(speed[start:middle])), float(np.mean(speed[middle - 1 : end]))
    mean = 0.5 * (first + last)
    is_moving = abs(mean) > _STEADY_LEAST * float(np.abs(speed).max())
    return is_moving and abs(last - first) < _STEADY_CHANGE * abs(mean)


def lost_rows(positions: Sequence[Array], others: Sequence[Array]) -> NDArray[np.int64]:
    """Rows before which all moving signals jump as far as if rows had been lost.

    Parameters
    ----------
    positions : sequence of ndarray, shape (n,)
        Measured positions, which cannot jump.
    others : sequence of ndarray, shape (n,)
        Signals such as the reference that would have to jump as well where they move.
    """
    found: set[int] = set()
    beside = [_steps(other) for other in others]
    for values in positions:
        own = _steps(values)
        for k in np.flatnonzero(own.jumps):
            if all(
                not other.moving[k] or abs(other.ratio[k] / own.ratio[k] - 1.0) < _ALIKE
                for other in beside
            ):
                found.add(int(k) + 1)
    return np.array(sorted(found), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class _Steps:
    """Each step over the usual one beside it, whether it jumps, whether the signal moves there."""

    ratio: Array
    jumps: NDArray[np.bool_]
    moving: NDArray[np.bool_]


def _steps(values: Array) -> _Steps:
    steps = np.diff(values)
    padded = np.pad(steps, 2, mode="edge")
    beside = np.stack([padded[:-4], padded[1:-3], padded[3:-1], padded[4:]])
    usual, between = np.median(beside, axis=0), np.ptp(beside, axis=0)
    excess = np.abs(steps - usual)
    quanta = _QUANTA * resolution(values)
    least = max(_JUMP_SHARE * float(np.quantile(np.abs(steps), 0.95)), quanta)
    spread = 1.4826 * float(np.median(excess))
    ratio = np.divide(steps, usual, out=np.zeros(steps.size), where=usual != 0.0)
    # A step after a repeat catches up: no row was lost.
    before = np.concatenate([[1.0], steps[:-1]])
    jumps = (
        (before != 0.0)
        & (ratio > _JUMP[0])
        & (ratio < _JUMP[1])
        & (excess > max(_JUMP_SPREADS * spread, least))
        # An axis that starts or stops within a row or two changes its steps as much by itself.
        & (excess > between)
    )
    return _Steps(ratio, jumps, np.abs(usual) > _MOVING * least)


def clock_quality(time: NDArray[np.float64], lost: NDArray[np.int64]) -> ClockQuality:
    """Judge the times of the rows.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Of the rows of the fastest signal.
    lost : ndarray of int
        Rows before which all signals jump.
    """
    steps = np.diff(time)
    usual = float(np.median(steps))
    places = np.round(steps / usual).clip(1.0)
    own = steps[places == 1.0]
    return ClockQuality(
        step=usual,
        jitter=float(np.abs(own / usual - 1.0).max()),
        lost_by_clock=int(np.sum(places - 1.0)),
        lost_at=tuple(float(time[row]) for row in lost if places[row - 1] == 1.0),
    )
