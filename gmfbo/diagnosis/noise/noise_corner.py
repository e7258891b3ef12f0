"""The frequency above which a reading holds nothing but noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_CORNERS = (30.0, 45.0, 65.0, 95.0, 140.0, 200.0)  # [Hz]
_WHITE = 1.6  # times the level near the Nyquist frequency: above it, the signal is motion
_SLOWER = 0.3  # of the sampling frequency: above this corner a signal has no fast part


def above(column: Array, step: float, corner: float) -> Array:
    """Part of a column above a frequency, without a shift in time.

    Parameters
    ----------
    column : ndarray, shape (n,)
        Evenly sampled.
    step : float
        [s] Between samples.
    corner : float
        [Hz] Sharp, so that filtering twice equals filtering once, and no model gains by having
        its noise read more often.
    """
    line = np.linspace(column[0], column[-1], column.size)
    return _fast(column - line, step, corner)


def corner_of_noise(difference: Array, step: float, level: float) -> float | None:
    """Frequency above which a difference is white noise.

    Parameters
    ----------
    difference : ndarray, shape (n,)
        Recorded less simulated reading.
    step : float
        [s] Between samples.
    level : float
        Standard deviation of its noise near the Nyquist frequency.

    Returns
    -------
    float or None
        [Hz] None where the difference is white nowhere.
    """
    n = difference.size
    # The second difference keeps the slow part's leakage out of the fast bins.
    taper = np.hanning(n - 2)
    power = np.abs(np.fft.rfft(taper * np.diff(difference, 2))) ** 2 / np.sum(taper**2)
    frequency = np.fft.rfftfreq(n - 2, step)
    power = power / np.maximum((2.0 * np.sin(np.pi * frequency * step)) ** 4, 1e-30)
    found = None
    for corner in reversed(_CORNERS):
        if corner >= _SLOWER / step:
            continue
        band = (frequency >= corner) & (frequency < 1.5 * corner)
        if not np.any(band) or float(np.mean(power[band])) > _WHITE * level**2:
            break
        found = corner
    return found


def _fast(column: Array, step: float, corner: float) -> Array:
    kept = np.fft.rfftfreq(column.size, step) >= corner
    fast: Array = np.fft.irfft(np.fft.rfft(column) * kept, column.size)
    return fast
