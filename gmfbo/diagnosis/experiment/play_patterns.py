"""References of the menu within limits: each begins and ends at rest where the axis stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from gmfbo.diagnosis.experiment.play_limits import PlayLimits, shrunk
from gmfbo.diagnosis.experiment.reference_menu import (
    PARTS,
    MenuEntry,
    RecordedLimits,
    reference_menu,
)
from gmfbo.errors import InputError

Column = NDArray[np.float64]

_SHARES = (0.9, 0.7, 0.5, 0.35, 0.2, 0.1)  # of the time of a part, tried one after the other
_REST_ROWS = 8  # at each end, so that differences of any order begin and end at zero
_TRAVEL = 0.15  # of velocity times duration: a range that slow patterns still cover in time
_FASTEST = 3.0  # times the frequency at which speed and acceleration reach their limits together
_SLOWEST_ROWS = 10.0  # rows of a chirp's fastest cycle
_LEAST_ROWS = 200


def play_patterns(limits: PlayLimits, start: float, spacing: float) -> tuple[MenuEntry, ...]:
    """Patterns that keep all limits of position, velocity, acceleration and jerk.

    Parameters
    ----------
    limits : PlayLimits
        Of the axis.
    start : float
        [rad or m] Where the axis stands; within the limits.
    spacing : float
        [s] Between rows.

    Returns
    -------
    tuple of MenuEntry
        Each at most half of the duration long.

    Raises
    ------
    InputError
        The time is too short for any.
    """
    rows = int(limits.duration / PARTS / spacing)
    found: dict[str, MenuEntry] = {}
    for share in _SHARES:
        for entry in _menu(limits, start, spacing, share * limits.duration / PARTS):
            values = _at_rest(entry.values, limits, start, spacing)
            if values.size <= rows and np.ptp(values) > 0.0:
                found.setdefault(entry.name, replace(entry, values=values))
    if not found:
        raise InputError(
            f"no reference fits into {limits.duration:g} s at a step of {spacing:g} s within these "
            "limits of acceleration and jerk; allow a longer duration"
        )
    return tuple(found.values())


def _menu(
    limits: PlayLimits, start: float, spacing: float, duration: float
) -> tuple[MenuEntry, ...]:
    if duration < _LEAST_ROWS * spacing:
        return ()
    reach = _TRAVEL * limits.velocity * duration
    meeting = limits.acceleration / (2.0 * np.pi * limits.velocity)
    bandwidth = min(_FASTEST * meeting, 1.0 / (_SLOWEST_ROWS * spacing))
    return reference_menu(
        RecordedLimits(
            start=start,
            low=max(limits.low, start - reach),
            high=min(limits.high, start + reach),
            speed=limits.velocity,
            acceleration=limits.acceleration,
            bandwidth=max(bandwidth, 4.0 / duration),
            duration=duration,
            step=0.0,
            spacing=spacing,
        )
    )


def _at_rest(values: Column, limits: PlayLimits, start: float, spacing: float) -> Column:
    """Round a pattern until its jerk fits, and let it rest at both ends.

    A moving mean of length T turns a change of acceleration by 2 a into the jerk 2 a / T.
    """
    width = 1
    if np.isfinite(limits.jerk):
        width = int(np.ceil(2.0 * limits.acceleration / limits.jerk / spacing)) + 1
    # A mean wider than the pattern would erase it; then the amplitude shrinks instead.
    width = min(width, max(1, values.size // 4))
    rest = np.full(width + _REST_ROWS, start)
    padded = np.concatenate([rest, values, rest])
    rounded = (
        uniform_filter1d(padded - start, width, mode="nearest") if width > 1 else padded - start
    )
    return shrunk(start + rounded, limits, start, spacing)
