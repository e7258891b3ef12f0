"""Whether a run settled: how large its late error is, compared with what its noise allows.

The late error of a run is the largest error over the last tenth of its horizon, each sample the
mean of three, divided by what counts as settled there: the settling band, four standard deviations
of the measurement noise or two counts of the sensor, whichever is largest. A run settled where the
late error is at most 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

LATE_SHARE = 0.1
"""Share of the horizon, at its end, in which a settled run stays within the band."""

NOISE_DEVIATIONS = 4.0
"""Standard deviations of the noise within which an error counts as settled: of a mean of three
samples they are seven, which no noise reaches."""

COUNTS = 2.0
"""Counts of the sensor within which an error counts as settled."""

MOST_TOLERANCE = 0.1
"""Share of the step that noise and counts can excuse: a larger error has not even ended its rise,
and an unstable loop must not pass as a noisy one."""

GROWTH = 1.1
"""Largest error of the second half of a run over that of the first from which its error grows; a
tenth covers where the samples of a periodic error fall."""

# Standard deviation of white noise from the median of its absolute second differences.
_MEDIAN_TO_DEVIATION = 1.0 / (0.6745 * np.sqrt(6.0))
_LEAST_ROWS = 8


def late_error(
    time: ArrayLike,
    response: ArrayLike,
    *,
    step_time: float,
    target: float,
    step_size: float,
    horizon: float,
    band: float,
    noise: float | None = None,
    rest_until: float | None = None,
) -> NDArray[np.float64]:
    """Late error of step responses over their tolerance; at most 1 where they settled.

    Parameters
    ----------
    time : array_like, shape (n,)
        [s], increasing.
    response : array_like, shape (..., n)
        Measured signal of each run, without NaN.
    step_time : float
        [s] Instant of the step.
    target : float
        Reference after the step [unit of the response].
    step_size : float
        Height of the step [unit of the response], may be negative.
    horizon : float
        [s] Length after the step that is scored.
    band : float
        Half width of the settling band, as a share of the step.
    noise : float, optional
        Standard deviation of the measurement noise [unit of the response]; estimated for each
        run unless given.
    rest_until : float, optional
        [s] End of the rest that noise is estimated from, where the response moves before the
        step already; the step unless given.

    Returns
    -------
    ndarray, shape (...)
        Dimensionless; infinite where a response is not finite.
    """
    times, values = np.asarray(time, dtype=float), np.asarray(response, dtype=float)
    late = _last_tenth(times, step_time, horizon)
    finite = np.isfinite(values).all(axis=-1)
    known = np.where(finite[..., None], values, target)
    before = times < (step_time if rest_until is None else rest_until)
    sigma = noise_of(known, before, late) if noise is None else np.full(finite.shape, noise)
    size = abs(step_size)
    tolerance = np.maximum(band * size, _excused(known, sigma, np.full(finite.shape, size)))
    error = np.abs(_smoothed(known - target)[..., late]).max(axis=-1)
    return np.asarray(np.where(finite, error / tolerance, np.inf))


def error_growth(
    time: ArrayLike,
    error: ArrayLike,
    *,
    scored: tuple[ArrayLike, ArrayLike] | None = None,
    size: float | None = None,
    noise: float | None = None,
) -> NDArray[np.float64]:
    """Largest error of the second half over that of the first, over what counts as growth.

    It takes the place of `late_error` where the reference does not end constant. An error within
    what noise and counts of the sensor excuse has not grown.

    Parameters
    ----------
    time : array_like, shape (n,)
        [s], increasing.
    error : array_like, shape (..., n)
        Measured signal minus its reference.
    scored : tuple of two array_like of bool, shape (n,), optional
        Rows from the begin of the scored part on, and rows up to its end; all unless given.
    size : float, optional
        Range of the reference [unit of the error]; the largest error of a run unless given.
    noise : float, optional
        Standard deviation of the measurement noise [unit of the error]; estimated for each run
        unless given.

    Returns
    -------
    ndarray, shape (...)
        At most 1 where the error does not grow; infinite where it is not finite.
    """
    times, values = np.asarray(time, dtype=float), np.asarray(error, dtype=float)
    everything = np.ones(times.size, dtype=bool)
    since, until = (np.asarray(rows, dtype=bool) for rows in scored or (everything, everything))
    rows = since & until
    finite = np.isfinite(values).all(axis=-1)
    known = np.where(finite[..., None], values, 0.0)
    within, most = times[rows], np.abs(known).max(axis=-1)
    second = rows & (times >= 0.5 * (within[0] + within[-1]))
    sigma = noise_of(known, ~since, rows) if noise is None else np.full(finite.shape, noise)
    excused = _excused(known, sigma, most if size is None else np.full(finite.shape, size))
    smooth = np.abs(_smoothed(known))
    first, last = smooth[..., rows & ~second].max(axis=-1), smooth[..., second].max(axis=-1)
    growth = last / np.maximum(np.maximum(GROWTH * first, excused), np.finfo(float).tiny)
    return np.asarray(np.where(finite, np.where(last == 0.0, 0.0, growth), np.inf))


def _excused(
    values: NDArray[np.float64], sigma: NDArray[np.float64], size: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Error that noise and counts of the sensor explain [unit of the values], shape (...)."""
    most, counts = MOST_TOLERANCE * size, COUNTS * _count(values)
    # A smallest step as large as that is the response itself, not the resolution of a sensor.
    excused = np.maximum(NOISE_DEVIATIONS * sigma, np.where(counts <= most, counts, 0.0))
    return np.asarray(np.minimum(excused, most))


def _last_tenth(times: NDArray[np.float64], step_time: float, horizon: float) -> NDArray[np.bool_]:
    end = step_time + horizon
    late = (times >= end - LATE_SHARE * horizon) & (times <= end)
    # Samples that are rarer than the last tenth: the last of them tells.
    late[np.searchsorted(times, end, side="right") - 1] = True
    return np.asarray(late)


def run_noise(
    time: NDArray[np.float64], response: NDArray[np.float64], step_time: float, horizon: float
) -> float:
    """Standard deviation of the measurement noise of one run [unit of the response].

    Parameters
    ----------
    time, response : ndarray, shape (n,)
        [s] and the measured signal, without NaN.
    step_time, horizon : float
        [s] Instant of the step, and length after it that is scored.
    """
    late = _last_tenth(time, step_time, horizon)
    return float(noise_of(response, time < step_time, late))


def noise_of(
    values: NDArray[np.float64], before: NDArray[np.bool_], late: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Standard deviation of white measurement noise, shape (...).

    It is the smaller of two: that at rest before the step, and that of the last tenth. A fast
    oscillation of an unstable loop looks like noise in the last tenth, but is not there at rest.

    Parameters
    ----------
    values : ndarray, shape (..., n)
        Measured signal of each run.
    before, late : ndarray of bool, shape (n,)
        Rows before the step, and of the last tenth.
    """
    parts = [values[..., rows] for rows in (before, late) if rows.sum() >= _LEAST_ROWS]
    if not parts:
        return np.zeros(values.shape[:-1])
    each = [np.median(np.abs(np.diff(part, n=2, axis=-1)), axis=-1) for part in parts]
    return np.asarray(np.min(each, axis=0) * _MEDIAN_TO_DEVIATION)


def short_of_settling(late: ArrayLike) -> NDArray[np.float64]:
    """Logarithm of the late error; zero where the run settled.

    Parameters
    ----------
    late : array_like, shape (...)
        See `late_error`.
    """
    return np.asarray(np.log(np.maximum(np.asarray(late, dtype=float), 1.0)))


def _count(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smallest step between neighbouring samples, shape (...); zero for a constant signal."""
    steps = np.abs(np.diff(values, axis=-1))
    least = np.min(np.where(steps > 0.0, steps, np.inf), axis=-1)
    return np.asarray(np.where(np.isfinite(least), least, 0.0))


def _smoothed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean of each sample and its two neighbours; the ends have one."""
    if values.shape[-1] < 3:
        return values
    padded = np.concatenate([values[..., :1], values, values[..., -1:]], axis=-1)
    return np.asarray((padded[..., :-2] + padded[..., 1:-1] + padded[..., 2:]) / 3.0)
