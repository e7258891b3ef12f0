"""Step metrics: overshoot, rise, settling and transient time, for many responses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.errors import InputError

METRICS = ("overshoot", "transient_time", "rise_time", "settling_time")
"""The metrics in the order in which the paper states its weights."""

RISE_LEVELS = (0.1, 0.9)
"""Shares of the step between which the rise time is measured."""

SETTLING_BAND = 0.02
"""Half width of the band: share of the step (settling) or of the peak error (transient)."""

WORST_OVERSHOOT = 100.0
"""[%] Overshoot assigned to a failed run."""


def step_metrics(
    time: ArrayLike,
    response: ArrayLike,
    *,
    step_time: float,
    step_size: float = 1.0,
    initial: float = 0.0,
    horizon: float,
    band: float = SETTLING_BAND,
) -> dict[str, NDArray[np.float64]]:
    """Metrics of step responses, interpolated between samples.

    The response is the line through its samples. With z = (y - initial) / step_size, error
    e = 1 - z and times from the step:

    - overshoot [%]: 100 max(z - 1, 0);
    - rise_time [s]: from the first z = 0.1 to the first z = 0.9;
    - settling_time [s]: after it `|e|` stays within the band;
    - transient_time [s]: after it `|e|` stays within the band times its own peak.

    The final value is the reference, not the last sample, so that a steady-state error shows. A
    level that is not reached within the horizon gets the horizon as its time. A response with a
    non-finite sample gets the worst case of `worst_metrics`.

    Parameters
    ----------
    time : array_like, shape (n,)
        [s], increasing.
    response : array_like, shape (..., n)
        Measured signal of each run.
    step_time : float
        [s] Instant of the step, also between samples.
    step_size : float
        Height of the step [unit of the response], may be negative.
    initial : float
        Reference before the step [unit of the response].
    horizon : float
        [s] Length after the step that is looked at.
    band : float
        Half width of the settling band, as a share of the step.

    Returns
    -------
    dict of str to ndarray, shape (...)
        One entry for each of `METRICS`; finite.

    Raises
    ------
    InputError
        Shapes disagree, the step is zero, or the samples do not cover the horizon.
    """
    times, responses = np.asarray(time, dtype=float), np.asarray(response, dtype=float)
    if step_size == 0.0 or not np.isfinite(step_size):
        raise InputError(f"step metrics: expected a step other than zero, got {step_size}")
    since_step, window = scored_window(times, responses, step_time, horizon)
    finite = np.asarray(np.isfinite(window).all(axis=-1))
    # A constant replaces broken responses, so that no warning or NaN arises from them.
    error = 1.0 - (np.where(finite[..., None], window, initial) - initial) / step_size
    measured, worst = _metrics_of_error(since_step, error, horizon, band), worst_metrics(horizon)
    return {name: np.where(finite, measured[name], worst[name]) for name in METRICS}


def worst_metrics(horizon: float) -> dict[str, float]:
    """Metrics of a failed run: 100 % overshoot, and the horizon for each time.

    Parameters
    ----------
    horizon : float
        [s] Length after the step that is looked at.

    Returns
    -------
    dict of str to float
        One entry for each of `METRICS` [% or s].
    """
    return {name: WORST_OVERSHOOT if name == "overshoot" else horizon for name in METRICS}


def _metrics_of_error(
    time: NDArray[np.float64], error: NDArray[np.float64], horizon: float, band: float
) -> dict[str, NDArray[np.float64]]:
    """Metrics of finite errors (share of the step) at times counted from it [s], shape (...)."""
    peak = np.abs(error).max(axis=-1)
    low, high = (_first_reach(time, 1.0 - error, level, horizon) for level in RISE_LEVELS)
    return {
        "overshoot": 100.0 * np.maximum(-error.min(axis=-1), 0.0),
        "transient_time": _last_outside(time, error, band * peak, horizon),
        "rise_time": np.where((error <= 1.0 - RISE_LEVELS[1]).any(axis=-1), high - low, horizon),
        "settling_time": _last_outside(time, error, np.full(peak.shape, band), horizon),
    }


def scored_window(
    time: NDArray[np.float64], response: NDArray[np.float64], step_time: float, horizon: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cut [step_time, step_time + horizon], with interpolated ends.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s], increasing.
    response : ndarray, shape (..., n)
        Signal of each run.
    step_time, horizon : float
        [s] Begin and length of the part.

    Returns
    -------
    since : ndarray, shape (m,)
        [s] Counted from `step_time`.
    values : ndarray, shape (..., m)
        The signals there.

    Raises
    ------
    InputError
        Shapes disagree, or the samples do not cover the part.
    """
    if time.ndim != 1 or time.size < 2 or response.shape[-1:] != time.shape:
        raise InputError(
            f"step metrics: expected time (n,) and responses (..., n) with n >= 2, "
            f"got {time.shape} and {response.shape}"
        )
    end = step_time + horizon
    # Times that are sums of rounded steps may miss the ends by rounding errors.
    slack = 1e-6 * (time[-1] - time[0]) / (time.size - 1)
    if not horizon > 0.0 or time[0] > step_time + slack or time[-1] < end - slack:
        raise InputError(
            f"step metrics: expected samples from {step_time:g} to {end:g} s, "
            f"got {time[0]:g} to {time[-1]:g} s; record longer or shorten the horizon"
        )
    inside = (time > step_time + slack) & (time < end - slack)
    times = np.concatenate(([step_time], time[inside], [end]))
    values = np.concatenate(
        (
            _at(time, response, step_time)[..., None],
            response[..., inside],
            _at(time, response, end)[..., None],
        ),
        axis=-1,
    )
    return times - step_time, values


def _at(
    time: NDArray[np.float64], response: NDArray[np.float64], instant: float
) -> NDArray[np.float64]:
    """Interpolate each response at one instant, shape (...)."""
    right = int(np.clip(np.searchsorted(time, instant), 1, time.size - 1))
    share = np.clip((instant - time[right - 1]) / (time[right] - time[right - 1]), 0.0, 1.0)
    # An end that falls on a sample must not get a NaN from its neighbour.
    if share < 1e-6 or share > 1.0 - 1e-6:
        return np.asarray(response[..., right if share > 0.5 else right - 1])
    return np.asarray((1.0 - share) * response[..., right - 1] + share * response[..., right])


def _first_reach(
    time: NDArray[np.float64], response: NDArray[np.float64], level: float, horizon: float
) -> NDArray[np.float64]:
    """[s] First time at which each response reaches `level`, shape (...); horizon where never."""
    above = response >= level
    right = np.argmax(above, axis=-1)
    left = np.maximum(right - 1, 0)
    before, after = _take(response, left), _take(response, right)
    rise = np.where(right > 0, after - before, 1.0)
    share = np.where(right > 0, (level - before) / rise, 0.0)
    reached = time[left] + share * (time[right] - time[left])
    return np.where(above.any(axis=-1), reached, horizon)


def _last_outside(
    time: NDArray[np.float64],
    error: NDArray[np.float64],
    band: NDArray[np.float64],
    horizon: float,
) -> NDArray[np.float64]:
    """[s] Last time at which |error| exceeds `band`, shape (...); horizon if at the end."""
    outside = np.abs(error) > band[..., None]
    last = time.size - 1
    left = last - np.argmax(outside[..., ::-1], axis=-1)
    right = np.minimum(left + 1, last)
    before = _take(error, left)
    side = np.sign(before)
    fall = side * (before - _take(error, right))
    # The error is outside on the left and inside on the right, so its fall is positive there.
    usable = outside.any(axis=-1) & (left < last)
    share = np.where(usable, (side * before - band) / np.where(usable, fall, 1.0), 0.0)
    entered = time[left] + share * (time[right] - time[left])
    return np.where(outside.any(axis=-1), np.where(left < last, entered, horizon), 0.0)


def _take(values: NDArray[np.float64], index: NDArray[np.int64]) -> NDArray[np.float64]:
    """Pick values[..., index] for each leading index, shape (...)."""
    return np.take_along_axis(values, index[..., None], axis=-1)[..., 0]
