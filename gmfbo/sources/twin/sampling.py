"""Recorded signals on the communication grid."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError

# A held row acts from the grid point on that is nearest to it, of two as near from the later one.
# From the next one on, a clock that jitters would delay a reference by half a step on average.
_LATE_SHARE = 0.5 * (1.0 - 1e-6)
# Quartz clocks are off by up to 100 ppm each, two by 200 ppm; beyond twice that they are no clocks.
_CLOCKS_APART = 4e-4
# Mean resultant length of rows' places within a step, above which they have one (Mardia 1972).
_ABOUT_THE_STEPS = 0.5
# A recording that ends this share of a step after a grid point needs no further point.
_END_SHARE = 1e-3


def steps_to_cover(time: NDArray[np.float64], step: float) -> int:
    """Communication steps from the first row that reach the last row.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Increasing.
    step : float
        [s] Communication step.
    """
    return max(0, int(np.ceil((time[-1] - time[0]) / step - _END_SHARE)))


def sample(
    time: NDArray[np.float64],
    values: NDArray[np.float64],
    grid: NDArray[np.float64],
    interpolation: Literal["hold", "linear"],
    name: str,
) -> NDArray[np.float64]:
    """Values of a recorded signal at grid points, shape of `grid`.

    Before its first sample a signal has the value of that sample; rows with NaN were not sampled.
    Evenly spaced, held rows are assigned to the grid's steps, or to every n-th step, where the
    clocks of logger and grid differ only by their tolerance. Otherwise a clock 150 ppm fast would
    shift a reference by a whole sample from 0.7 s on.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Increasing.
    values : ndarray, shape (n,)
        NaN where not sampled.
    grid : ndarray
        [s] Evenly spaced.
    interpolation : {"hold", "linear"}
        Between rows.
    name : str
        Of the signal, for the message.

    Raises
    ------
    RecordingError
        The signal has no sample, or an infinite one.
    """
    sampled = ~np.isnan(values)
    if not sampled.any():
        raise RecordingError(f"signal '{name}': expected values to drive the twin, all are blank")
    if np.isinf(values).any():
        row = int(np.argmax(np.isinf(values)))
        raise RecordingError(f"signal '{name}': row {row} is infinite; expected a finite value")
    known_time, known = time[sampled], values[sampled]
    if interpolation == "linear":
        return np.interp(grid, known_time, known)
    # Jitter is compared with the finer of the two spacings.
    spacing = min(
        float(np.median(np.diff(known_time))) if known_time.size > 1 else np.inf,
        float(grid[1] - grid[0]) if grid.size > 1 else np.inf,
    )
    late = _LATE_SHARE * spacing if np.isfinite(spacing) else 0.0
    if grid.size > 1:
        step = float(grid[1] - grid[0])
        known_time = known_time - _beside_the_grid(known_time - grid[0], step)
        known_time = _by_the_clock_of(step, known_time, late)
    rows = np.searchsorted(known_time, grid + late, side="right") - 1
    return known[np.clip(rows, 0, None)]


def _beside_the_grid(since: NDArray[np.float64], step: float) -> float:
    """[s] By which rows that jitter about every step, or every n-th, are later than the grid.

    The grid begins at the first row, whose stamp jitters as well. Rows at another rate lie
    anywhere between the steps, and are left where they are.
    """
    turns = np.mean(np.exp(2j * np.pi * since / step))
    off = float(np.angle(turns)) / (2.0 * np.pi)
    return off * step if abs(turns) > _ABOUT_THE_STEPS and abs(off) > _END_SHARE else 0.0


def _by_the_clock_of(step: float, time: NDArray[np.float64], late: float) -> NDArray[np.float64]:
    """Times of rows by the grid's clock, where the two clocks differ only by their tolerance."""
    count = time.size - 1
    if count < 1:
        return time
    spacing = float(time[-1] - time[0]) / count
    often = max(1, round(spacing / step))
    drift = count * (spacing - often * step)
    if abs(drift) <= late or abs(drift) > _CLOCKS_APART * count * often * step:
        return time
    even = time[0] + np.arange(time.size) * spacing
    if np.abs(time - even).max() > late:
        return time
    return time - np.linspace(0.0, drift, time.size)
