"""Check that a time column is a clock that a simulation can follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError

JITTER = 0.1  # deviation of a step from the mean step, as a share of it, up to which it is even
_DIGITS = tuple(10.0**-k for k in range(10))  # [s] last digit of a clock, the coarsest first
_NEARLY = 1e-3  # of a digit: binary numbers hold no decimals
_OFTEN = 0.02  # of the steps: rarer ones are faults
GAP = 2.5
"""Longest step, in median steps: one lost row lengthens a hold by a step, two are a gap."""


def check_clock(
    label: str,
    time: NDArray[np.float64],
    sampled: Sequence[NDArray[np.bool_]],
    row_name: Callable[[int], str],
) -> str:
    """Raise for a clock that stands still, goes back or has gaps; tell whether it jitters.

    Steps may differ by 10 % from their mean. Beyond that each signal counts at its own instants,
    unless a step is longer than 2.5 usual ones. Where signals have different rates, the sampling
    instants of each signal are checked separately.

    Parameters
    ----------
    label : str
        File name.
    time : ndarray, shape (n,)
        [s]
    sampled : sequence of ndarray, shape (n,)
        Rows at which each signal has a value.
    row_name : callable
        Place of row k (from 0) in the file.

    Returns
    -------
    str
        A note about jitter beyond 10 %; empty without.

    Raises
    ------
    RecordingError
        Names the first bad row and its time; for a gap the worst one.
    """
    check_order(label, time, row_name)
    steps = np.diff(time)
    row = _worst_step(time)
    if row is None or _each_on_its_own_clock(time, sampled):
        return ""
    usual, longest = float(np.median(steps)), int(np.argmax(steps)) + 1
    if steps[longest - 1] > GAP * usual:
        raise RecordingError(
            f"{label}, {row_name(longest)}, at {time[longest]:.9g} s: there is a gap of "
            f"{steps[longest - 1]:.6g} s, expected steps of about {usual:.6g} s; cut the "
            f"recording there, or have it interpolated by [recording] resample = {usual:.3g} in "
            "the twin file"
        )
    return (
        f"{label}: rows come {steps.min():.3g} to {steps.max():.3g} s apart: the twin runs at its "
        "own step, inputs are held, each signal is compared at its own instants by interpolation"
    )


def unrounded(time: NDArray[np.float64]) -> tuple[NDArray[np.float64], float] | None:
    """Even times of rows whose clock was written with too few digits.

    Rows of 2.5 ms on a clock of whole milliseconds come 2 and 3 ms apart. Where one even clock,
    rounded, gives all of them, it is the one that was rounded: jitter does not do that.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Increasing.

    Returns
    -------
    tuple of ndarray and float, or None
        [s] Even times, shape (n,), and the last digit of the clock; None where rows are even as
        they are, or no even clock was rounded.
    """
    if _worst_step(time) is None:
        return None
    since = time - time[0]
    ticks = (d for d in _DIGITS if np.abs(since / d - np.round(since / d)).max() < _NEARLY)
    tick = next(ticks, None)
    if tick is None:
        return None
    rows = np.arange(time.size, dtype=np.float64)
    slope = float(np.polyfit(rows, since, 1)[0])
    if not _alternates(np.diff(since) / tick, slope / tick):
        return None
    # What a logger is set to has few digits.
    for spacing in (*(float(f"{slope:.{digits}g}") for digits in range(1, 10)), slope):
        off = since - spacing * rows
        if np.ptp(off) <= tick * (1.0 + _NEARLY):
            begins = float(np.clip(0.0, off.max() - 0.5 * tick, off.min() + 0.5 * tick))
            begins = begins if abs(begins) > _NEARLY * tick else 0.0
            return time[0] + begins + spacing * rows, tick
    return None


def _alternates(steps: NDArray[np.float64], usual: float) -> bool:
    """Whether steps, in digits, are the whole numbers about a mean, and both of them often.

    Of a digit as long as a row, or of one step among many, it cannot be told from a lost row.
    """
    short = np.floor(usual)
    is_short, is_long = (np.abs(steps - k) < _NEARLY for k in (short, short + 1.0))
    often = min(int(is_short.sum()), int(is_long.sum())) >= max(_OFTEN * steps.size, 5)
    return bool(short >= 2.0 and np.all(is_short | is_long) and often)


def check_order(label: str, time: NDArray[np.float64], row_name: Callable[[int], str]) -> None:
    """Raise for a clock with blanks, or one that stands still or goes back.

    Parameters
    ----------
    label : str
        File name.
    time : ndarray, shape (n,)
        [s]
    row_name : callable
        Place of row k (from 0) in the file.

    Raises
    ------
    RecordingError
        Names the first bad row and its time.
    """
    for row in np.flatnonzero(~np.isfinite(time))[:1]:
        raise RecordingError(
            f"{label}, {row_name(row)}: expected a finite time, got a blank cell or NaN; "
            "complete or delete the row"
        )
    steps = np.diff(time)
    for row in np.flatnonzero(steps <= 0.0)[:1] + 1:
        was, now = time[row - 1], time[row]
        if now == was:
            raise RecordingError(
                f"{label}, {row_name(row)}: time {now:.9g} s stands twice; put what was sampled "
                "at one instant into one row, and log time with enough digits"
            )
        raise RecordingError(
            f"{label}, {row_name(row)}: time goes back from {was:.9g} s to {now:.9g} s; "
            "expected rows in the order of time, cut the recording there"
        )


def is_steady(time: NDArray[np.float64]) -> bool:
    """Whether steps are positive and within 10 % of their mean.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s]
    """
    return bool(np.all(np.diff(time) > 0.0)) and _worst_step(time) is None


def _worst_step(time: NDArray[np.float64]) -> int | None:
    """Row after the step that differs most from the mean; None where all steps are even."""
    if time.size < 3:
        return None
    steps = np.diff(time)
    deviation = np.abs(steps - steps.mean())
    worst = int(np.argmax(deviation))
    # The tolerance is for round-off in a clock with a large offset, such as seconds since 1970.
    slack = 4.0 * np.spacing(np.max(np.abs(time)))
    return worst + 1 if deviation[worst] > JITTER * steps.mean() + slack else None


def _each_on_its_own_clock(time: NDArray[np.float64], sampled: Sequence[NDArray[np.bool_]]) -> bool:
    masks = [mask for mask in sampled if mask.any()]
    if not masks or any(mask.all() for mask in masks):
        return False
    return all(_worst_step(time[mask]) is None for mask in masks)
