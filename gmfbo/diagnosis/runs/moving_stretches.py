"""Long recordings: the stretches of them in which the axis shows most, for a diagnosis in minutes.

A diagnosis simulates what it compares some thousand times. Of recordings of more steps of the twin
than `MOST_STEPS` it takes the stretches, of `STRETCH` steps, that together tell most: greedily by
the determinant of the information about a linear model of all recorded signals, their squares,
rates, directions and accelerations (D-optimal design; Fedorov 1972, "Theory of Optimal
Experiments", chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS
from gmfbo.plain_words import listed
from gmfbo.recordings.recording import Recording

Array = NDArray[np.float64]

MOST_STEPS = 40_000
"""Steps of the twin in all that are compared, 40 s at 1 ms: of 60,000 one took 17 minutes."""

ROWS_A_STEP = 10
"""Rows that take as much time and memory as a step of the twin."""

STRETCH = 6_000
"""Steps of a stretch; recordings that are hardly longer stay whole."""

_CUT_WITHIN = 0.25  # of a stretch, about its end: it is cut where the axis moves least
_CALM = 0.05  # of a stretch, over which it moves least
_BLOCKS = 400  # means over rows by which a stretch is judged
_STANDSTILL = 0.05  # of a signal's RMS rate, around which a direction has no sign
_RIDGE = 1e-3  # information that any signal has before the first stretch, of that of all


@dataclass(frozen=True, eq=False)
class Stretches:
    """What is compared of recordings.

    Attributes
    ----------
    recordings : tuple of Recording
        Recordings, or stretches of them under names that tell the times.
    notes : tuple of str
        What was taken, for the reader; none where all is.
    """

    recordings: tuple[Recording, ...]
    notes: tuple[str, ...] = ()


def moving_stretches(
    recordings: Sequence[Recording],
    signals: Sequence[str],
    step: float,
) -> Stretches:
    """Take all recordings, or where these are long the stretches that tell most.

    Parameters
    ----------
    recordings : sequence of Recording
        Runs of the real axis.
    signals : sequence of str
        Names of those that are compared with the twin.
    step : float
        [s] Communication step of the twin.
    """
    sizes = [_size(one, step) for one in recordings]
    if sum(sizes) <= MOST_STEPS:
        return Stretches(tuple(recordings))
    pieces = [
        piece
        for one, size in zip(recordings, sizes, strict=True)
        for piece in _pieces(one, signals, int(size / STRETCH))
    ]
    taken = tuple(pieces[k] for k in sorted(_most_telling(pieces, signals, step)))
    total, seconds = (sum(one.duration for one in some) for some in (recordings, taken))
    note = (
        f"{total:.0f} s were recorded; for a diagnosis in minutes the {seconds:.0f} s were "
        f"compared that show most: {listed([one.name for one in taken])}. To compare others, give "
        "them as files of their own"
    )
    return Stretches(taken, (note,))


def _size(recording: Recording, step: float) -> float:
    """Steps of the twin [s], or as many as its rows are worth."""
    return max(recording.duration / step, len(recording) / ROWS_A_STEP)


def _pieces(recording: Recording, signals: Sequence[str], count: int) -> list[Recording]:
    """About this number of stretches of a recording, cut where it moves least."""
    if count < 2:
        return [recording]
    time, length = recording.time, recording.duration / count
    calm = _motion(recording, signals, _CALM * length)
    edges = [0]
    for k in range(1, count):
        middle = time[0] + k * length
        slack = _CUT_WITHIN * length
        first, last = np.searchsorted(time, [middle - slack, middle + slack])
        edges.append(int(first + np.argmin(calm[first:last])) if last > first else int(first))
    found = []
    for first, last in pairwise([*edges, len(time)]):
        if last - first < LEAST_ROWS:
            continue  # in a gap of the recording
        rows = slice(first, last)
        name = f"{recording.name} [{time[first]:.4g}, {time[last - 1]:.4g}] s"
        part = replace(
            recording,
            time=time[rows],
            signals={key: column[rows] for key, column in recording.signals.items()},
            schedules={key: column[rows] for key, column in recording.schedules.items()},
            name=name,
            start_time=recording.start_time if first == 0 else "",
        )
        use = recording.use
        if use is None or (use[0] <= part.time[-1] and use[1] >= part.time[0]):
            found.append(part)
    return found


def _motion(recording: Recording, signals: Sequence[str], seconds: float) -> Array:
    """How much the signals move within a time [s] around each row, shape (n,)."""
    width = max(3, int(seconds / recording.duration * len(recording)))
    moved = np.zeros(len(recording))
    for column in (_bridged(recording, name) for name in signals):
        rate = np.abs(np.gradient(column))
        moved += uniform_filter1d(rate, width) / max(float(np.mean(rate)), 1e-300)
    return moved


def _bridged(recording: Recording, name: str) -> Array:
    """A signal with its gaps bridged; zero where it was not recorded, since it tells nothing."""
    column = recording.signals.get(name)
    known = np.isfinite(column) if column is not None else np.zeros(len(recording), dtype=bool)
    if column is None or known.sum() < 2:
        return np.zeros(len(recording))
    return np.interp(recording.time, recording.time[known], column[known])


def _most_telling(pieces: Sequence[Recording], signals: Sequence[str], step: float) -> list[int]:
    """Places of the stretches that together tell most, until `MOST_STEPS` are used up."""
    sizes = [_size(piece, step) for piece in pieces]
    rows = [_features(piece, signals) for piece in pieces]
    every = np.concatenate(rows)
    scale = np.sqrt(np.mean(every**2, axis=0))
    rows = [one[:, scale > 0.0] / scale[scale > 0.0] for one in rows]
    groups = {tuple(sorted(one.parameters.items())) for one in pieces}
    informs = [one.T @ one / len(one) * size for one, size in zip(rows, sizes, strict=True)]
    least = _RIDGE * sum(sizes) * np.eye(informs[0].shape[0])
    known = dict.fromkeys(groups, least)
    chosen: list[int] = []
    spent = 0.0
    while left := [
        k for k in range(len(pieces)) if k not in chosen and spent + sizes[k] <= MOST_STEPS
    ]:
        gains = {
            k: _gain(known[tuple(sorted(pieces[k].parameters.items()))], informs[k]) for k in left
        }
        best = max(left, key=lambda k: gains[k] / sizes[k])
        group = tuple(sorted(pieces[best].parameters.items()))
        known[group] = known[group] + informs[best]
        chosen.append(best)
        spent += sizes[best]
    return chosen


def _gain(known: Array, more: Array) -> float:
    """Growth of the logarithm of the determinant of the information."""
    return float(np.linalg.slogdet(known + more)[1] - np.linalg.slogdet(known)[1])


def _features(piece: Recording, signals: Sequence[str]) -> Array:
    """Signals, squares, rates, directions and accelerations of blocks, shape (blocks, features)."""
    blocks = np.array_split(np.arange(len(piece)), min(_BLOCKS, len(piece)))
    time = np.array([piece.time[rows].mean() for rows in blocks])
    found = []
    for column in (_bridged(piece, name) for name in signals):
        value = np.array([column[rows].mean() for rows in blocks])
        rate = np.gradient(value, time)
        typical = max(float(np.sqrt(np.mean(rate**2))), 1e-300)
        direction = rate / (np.abs(rate) + _STANDSTILL * typical)
        found += [value, value**2, rate, rate * np.abs(rate), direction, np.gradient(rate, time)]
    return np.column_stack(found)
