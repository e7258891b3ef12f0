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
    frequency = np.fft.rfftfreq(difference.size - 2, step)
    power = np.abs(_bins(difference, step)) ** 2
    found = None
    for corner in reversed(_CORNERS):
        if corner >= _SLOWER / step:
            continue
        band = (frequency >= corner) & (frequency < 1.5 * corner)
        if not np.any(band) or float(np.mean(power[band])) > _WHITE * level**2:
            break
        found = corner
    return found


def fast_bins(columns: Array, step: float, corner: float) -> NDArray[np.complex128]:
    """Spectra above a frequency, into which nothing slower leaks.

    Parameters
    ----------
    columns : ndarray, shape (..., n)
        Evenly sampled.
    step : float
        [s] Between samples.
    corner : float
        [Hz] Of the slowest bin.

    Returns
    -------
    ndarray of complex, shape (..., n_bins)
        White noise of variance 1 has a mean square of 1.
    """
    frequency = np.fft.rfftfreq(columns.shape[-1] - 2, step)
    return _bins(columns, step)[..., frequency >= corner]


def _bins(columns: Array, step: float) -> NDArray[np.complex128]:
    """Tapered spectra by the second difference, which keeps the slow part out of fast bins."""
    rows = columns.shape[-1] - 2
    taper = np.hanning(rows)
    bins = np.fft.rfft(taper * np.diff(columns, 2)) / np.sqrt(np.sum(taper**2))
    slope = 2.0 * np.sin(np.pi * np.fft.rfftfreq(rows, step) * step)
    return np.asarray(bins / np.maximum(slope**2, 1e-15), dtype=np.complex128)


def _fast(column: Array, step: float, corner: float) -> Array:
    kept = np.fft.rfftfreq(column.size, step) >= corner
    fast: Array = np.fft.irfft(np.fft.rfft(column) * kept, column.size)
    return fast
