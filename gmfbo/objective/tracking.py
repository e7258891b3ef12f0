"""Metrics of tracking error and of the command, for any reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import trapezoid

from gmfbo.objective.metrics import scored_window

TRACKING_METRICS = ("itae", "rms_error")
"""Metrics of the error between reference and response."""

COMMAND_METRICS = ("rms_command", "peak_command", "command_noise", "energy")
"""Metrics that need the actuator command."""


def tracking_metrics(
    time: ArrayLike, error: ArrayLike, *, begin: float, horizon: float
) -> dict[str, NDArray[np.float64]]:
    """ITAE and RMS of the tracking error, the line through its samples.

    - itae [unit s^2]: integral of (t - begin) `|e|` (Graham and Lathrop 1953);
    - rms_error [unit]: root of the mean of e^2 over time.

    Parameters
    ----------
    time : array_like, shape (n,)
        [s], increasing.
    error : array_like, shape (..., n)
        Reference minus response of each run.
    begin, horizon : float
        [s] Begin and length of the part that is scored.

    Returns
    -------
    dict of str to ndarray, shape (...)
        One entry for each of `TRACKING_METRICS`; infinite for an error that is not finite.

    Raises
    ------
    InputError
        The samples do not cover the part.
    """
    since, window = scored_window(np.asarray(time, float), np.asarray(error, float), begin, horizon)
    finite = np.asarray(np.isfinite(window).all(axis=-1))
    known = np.where(finite[..., None], window, 0.0)
    measured = {
        "itae": trapezoid(since * np.abs(known), since, axis=-1),
        "rms_error": _rms(since, known),
    }
    return {name: np.where(finite, value, np.inf) for name, value in measured.items()}


def command_metrics(
    time: ArrayLike,
    command: ArrayLike,
    *,
    begin: float,
    horizon: float,
    jumps: ArrayLike = (),
) -> dict[str, float]:
    """RMS, peak and noise of the command.

    - rms_command [unit]: root of the mean of u^2 over time;
    - peak_command [unit]: largest `|u|` of a sample;
    - command_noise [unit]: RMS of the fast part, what a sample differs by from the line through
      its neighbours, scaled so that it is the standard deviation of white noise (Gasser, Sroka
      and Jennen-Steinmetz 1986). Samples beside a jump of the reference are left out, since the
      command has to jump there.

    Parameters
    ----------
    time, command : array_like, shape (n,)
        [s], increasing, and the command.
    begin, horizon : float
        [s] Begin and length of the part that is scored.
    jumps : array_like, shape (j,)
        [s] When the reference or a disturbance jumps.

    Returns
    -------
    dict of str to float
        RMS, peak and noise [unit of the command]; infinite for a command that is not finite.

    Raises
    ------
    InputError
        The samples do not cover the part.
    """
    times, values = np.asarray(time, dtype=float), np.asarray(command, dtype=float)
    since, window = scored_window(times, values, begin, horizon)
    names = COMMAND_METRICS[:3]
    if not np.isfinite(window).all():
        return dict.fromkeys(names, np.inf)
    inside = (times >= begin) & (times <= begin + horizon)
    fast = _fast_part(times[inside], values[inside], np.asarray(jumps, dtype=float))
    noise = float(np.sqrt(np.mean(fast**2))) if fast.size else 0.0
    measured = (float(_rms(since, window)), float(np.abs(window).max()), noise)
    return dict(zip(names, measured, strict=True))


def spent_energy(
    time: ArrayLike,
    command: ArrayLike,
    motion: ArrayLike,
    *,
    begin: float,
    horizon: float,
    is_velocity: bool = False,
) -> float:
    """Work that the actuator does, without what it takes back.

    Integral of max(u v, 0) over time. From positions, v dt is the way between two samples: noise
    of the position then adds to the work, so smooth it before.

    Parameters
    ----------
    time, command, motion : array_like, shape (n,)
        [s], increasing; force or torque; and what it moves.
    begin, horizon : float
        [s] Begin and length of the part that is scored.
    is_velocity : bool
        Whether `motion` is a velocity; otherwise it is a position.

    Returns
    -------
    float
        [unit of the command times unit of the position]: [J] for torque and angle, or force and
        way. Infinite where a signal is not finite.

    Raises
    ------
    InputError
        The samples do not cover the part.
    """
    times = np.asarray(time, dtype=float)
    both = np.stack([np.asarray(command, dtype=float), np.asarray(motion, dtype=float)])
    since, (force, moved) = scored_window(times, both, begin, horizon)
    if not (np.isfinite(force).all() and np.isfinite(moved).all()):
        return float(np.inf)
    if is_velocity:
        return float(trapezoid(np.maximum(force * moved, 0.0), since))
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(moved)
    return float(np.maximum(work, 0.0).sum())


def _rms(since: NDArray[np.float64], window: NDArray[np.float64]) -> NDArray[np.float64]:
    length = since[-1] - since[0]
    return np.asarray(np.sqrt(trapezoid(window**2, since, axis=-1) / length))


def _fast_part(
    time: NDArray[np.float64], values: NDArray[np.float64], jumps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Differences from the line through both neighbours, without those that span a jump."""
    if time.size < 3:
        return np.empty(0)
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    fast = values[1:-1] - (1.0 - share) * values[:-2] - share * values[2:]
    fast /= np.sqrt(1.0 + (1.0 - share) ** 2 + share**2)
    # A sampled controller answers one sample after the jump.
    step = float(np.median(np.diff(time)))
    spans = [(time[:-2] <= jump + 1.5 * step) & (time[2:] >= jump - 0.5 * step) for jump in jumps]
    return np.asarray(fast[~np.any(spans, axis=0)] if len(spans) else fast)
