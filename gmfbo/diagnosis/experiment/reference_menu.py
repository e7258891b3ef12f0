"""Menu of safe references: none goes farther, faster or harder than the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from gmfbo.diagnosis.experiment.play_limits import PlayLimits, shrunk

_ROUNDED = 0.3  # of a piece of a path: most that its corners take
_SMALL = 0.2  # of the large amplitude
_CYCLES = (3, 12)
_SPEED_SHARE, _ACCELERATION_SHARE = 0.8, 0.6  # of a sine's: the rest is for fading in and out
_LADDER = 4
_LONGEST = 4.0  # times the longest recording; a longer reference is left out

Column = NDArray[np.float64]

PARTS = 2
"""Number of patterns that are played one after the other."""


@dataclass(frozen=True)
class RecordedLimits:
    """Limits of motion that the recordings show to be safe.

    Attributes
    ----------
    start : float
        [SI unit of the reference] Where each reference begins and ends.
    low, high : float
        [SI unit of the reference] Lowest and highest value.
    speed : float
        [SI unit/s]
    acceleration : float
        [SI unit/s2]
    bandwidth : float
        [Hz] Up to which the reference moved.
    duration : float
        [s] Of the longest recording.
    step : float
        [SI unit of the reference] Largest jump, with its sign; 0 where there was none.
    spacing : float
        [s] Sampling time.
    """

    start: float
    low: float
    high: float
    speed: float
    acceleration: float
    bandwidth: float
    duration: float
    step: float
    spacing: float

    @property
    def stroke(self) -> float:
        """Whole range [SI unit of the reference]."""
        return self.high - self.low


@dataclass(frozen=True, eq=False)
class MenuEntry:
    """One pattern.

    Attributes
    ----------
    name : str
        For a file, such as `slow_triangle`.
    words : str
        For a sentence, with its article.
    values : ndarray, shape (rows,)
        [SI] From the start, and back to it.
    """

    name: str
    words: str
    values: Column


def reference_menu(limits: RecordedLimits) -> tuple[MenuEntry, ...]:
    """Build the patterns that these limits allow, each to be played before or after another."""
    entries = [
        MenuEntry("slow_triangle", "a slow triangle", _triangle(limits)),
        MenuEntry("hold_ladder", "a ladder of holds", _ladder(limits)),
        MenuEntry("two_amplitudes", "reversals at two amplitudes", _reversals(limits)),
        MenuEntry("chirp", "a chirp", _chirp(limits)),
    ]
    rows = _LONGEST * limits.duration / limits.spacing
    short = [entry for entry in entries if entry.values.size < rows]
    entries = short or [min(entries, key=lambda entry: entry.values.size)]
    bounds = PlayLimits(limits.low, limits.high, limits.speed, limits.acceleration, limits.duration)
    entries = [
        replace(entry, values=shrunk(entry.values, bounds, limits.start, limits.spacing))
        for entry in entries
    ]
    if limits.step:
        entries.append(MenuEntry("step", "a step", _step(limits)))
    return tuple(entries)


def _triangle(limits: RecordedLimits) -> Column:
    """Once through the whole range, in about the time of the longest recording."""
    places = [limits.high, limits.low, limits.start]
    ways = np.abs(np.diff([limits.start, *places]))
    times = 0.8 * limits.duration * ways / max(ways.sum(), 1e-300)
    kept = [(t, place) for t, place in zip(times, places, strict=True) if t > 0.0]
    return _path(kept, limits)


def _ladder(limits: RecordedLimits) -> Column:
    """Up and down in equal steps, with a hold after each that is three times as long."""
    up = list(np.linspace(limits.low, limits.high, _LADDER + 1))
    places = [*up, *up[-2::-1], limits.start]
    piece = limits.duration / (4.0 * len(places))
    points: list[tuple[float, float]] = []
    for place in places:
        points += [(piece, place), (3.0 * piece, place)]
    return _path(points, limits)


def _reversals(limits: RecordedLimits) -> Column:
    large = 0.45 * limits.stroke
    parts = [_sine(amplitude, limits) for amplitude in (large, _SMALL * large)]
    return _about_centre(np.concatenate(parts), limits)


def _sine(amplitude: float, limits: RecordedLimits) -> Column:
    """Whole cycles that fade in and out, where possible in half of the longest recording's time."""
    fastest = min(
        _SPEED_SHARE * limits.speed / amplitude,
        np.sqrt(_ACCELERATION_SHARE * limits.acceleration / amplitude),
        2.0 * np.pi * limits.bandwidth,
    )
    cycles = float(np.clip(np.floor(0.5 * limits.duration * fastest / (2.0 * np.pi)), *_CYCLES))
    period = 2.0 * np.pi / fastest
    time = np.arange(round(cycles * period / limits.spacing), dtype=np.float64) * limits.spacing
    faded = _rise(time / period) * _rise(cycles - time / period)
    return np.asarray(amplitude * faded * np.sin(fastest * time))


def _chirp(limits: RecordedLimits) -> Column:
    """Chirp from one cycle in half the time to the recorded bandwidth, within the limits."""
    duration = limits.duration
    lowest = min(2.0 / duration, 0.5 * limits.bandwidth)
    rate = np.log(limits.bandwidth / lowest) / duration
    time = np.arange(round(duration / limits.spacing), dtype=np.float64) * limits.spacing
    angular = 2.0 * np.pi * lowest * np.exp(rate * time)
    bounds = [
        np.full(time.size, 0.45 * limits.stroke),
        _SPEED_SHARE * limits.speed / angular,
        _ACCELERATION_SHARE * limits.acceleration / angular**2,
    ]
    # A minimum without corners, each of which would be a jerk.
    amplitude = np.sum([bound**-4.0 for bound in bounds], axis=0) ** -0.25
    phase = 2.0 * np.pi * lowest * np.expm1(rate * time) / rate
    faded = _rise(5.0 * time / duration) * _rise(5.0 * (1.0 - time / duration))
    return _about_centre(amplitude * faded * np.sin(phase), limits)


def _step(limits: RecordedLimits) -> Column:
    """The largest recorded jump, held, and back."""
    rows = max(4, round(limits.duration / limits.spacing))
    place = np.arange(rows) / rows
    inside = (place >= 0.1) & (place < 0.55)
    return np.where(inside, limits.start + limits.step, limits.start)


# ---- shapes -------------------------------------------------------------------------------------


def _path(points: Sequence[tuple[float, float]], limits: RecordedLimits) -> Column:
    """Path of straight pieces (duration, target), stretched and rounded to keep the limits.

    A moving mean of length T turns a change of slope s into the acceleration s / T.
    """
    times = np.array([t for t, _ in points])
    places = np.array([limits.start, *(place for _, place in points)])
    slopes = np.diff(places) / times
    turns = np.abs(np.diff([0.0, *slopes, 0.0])).max()
    stretch = max(
        1.0,
        float(np.abs(slopes).max()) / limits.speed,
        np.sqrt(turns / (limits.acceleration * _ROUNDED * times.min())),
    )
    times = times * stretch
    rounded = turns / stretch / limits.acceleration
    width = int(np.ceil(rounded / limits.spacing)) + 2
    corners = np.concatenate([[0.0], np.cumsum(times)]) + width * limits.spacing
    whole = corners[-1] + width * limits.spacing
    time = np.arange(int(np.ceil(whole / limits.spacing)) + 1) * limits.spacing
    raw = np.interp(time, corners, places)
    smooth = uniform_filter1d(raw, width, mode="nearest")
    return np.asarray(smooth, dtype=np.float64)


def _about_centre(shape: Column, limits: RecordedLimits) -> Column:
    """Go to the middle of the range, follow the shape there, and come back."""
    centre = 0.5 * (limits.low + limits.high)
    way = centre - limits.start
    time_s = max(2.0 * abs(way) / limits.speed, np.sqrt(7.0 * abs(way) / limits.acceleration))
    rows = max(2, int(np.ceil(time_s / limits.spacing)))
    there = limits.start + way * _rise(np.arange(rows) / rows)
    return np.concatenate([there, centre + shape, there[::-1]])


def _rise(x: Column) -> Column:
    """Go from 0 to 1 with no slope at both ends, shape as x."""
    inside = np.clip(x, 0.0, 1.0)
    return np.asarray(inside * inside * (3.0 - 2.0 * inside))
