"""Frequency response from the reference to a signal, straight from recordings.

From command to measurement the loop feeds noise back, and the estimate is biased towards the
inverse of the controller (Ljung 1999, 13.4); the reference is independent of the noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend
from scipy.signal.windows import hann

Array = NDArray[np.float64]

TRUSTED_COHERENCE = 0.8
"""Below it, the reference does not cause more than a fifth of a signal's power."""

_SEGMENTS = 3.0  # of the shortest recording; half of each overlaps with the next
_LEAST_ROWS = 32
_EXCITED = 1e-5  # of the reference's strongest line: weaker ones are rounding and leakage


@dataclass(frozen=True, eq=False)
class Response:
    """H1 = S_xy / S_xx by the method of Welch (1967), where the source excites.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        [Hz]
    value : ndarray of complex, shape (n,)
        [signal's unit / source's unit]
    coherence : ndarray, shape (n,)
        0 to 1.
    averages : float
        Segments that count as independent.
    """

    frequency: Array
    value: NDArray[np.complex128]
    coherence: Array
    averages: float

    @property
    def trusted(self) -> tuple[float, float]:
        """[Hz] Widest band of high coherence, single bins left aside; NaN where there is none."""
        good = self.coherence >= TRUSTED_COHERENCE
        if not good.any():
            return float("nan"), float("nan")
        # One bin between two good ones may be a gap between the reference's lines.
        bridged = good.copy()
        bridged[1:-1] |= good[:-2] & good[2:]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], bridged, [False]]).astype(int)))
        starts, ends = edges[::2], edges[1::2]
        widest = int(np.argmax(ends - starts))
        return (
            float(self.frequency[starts[widest]]),
            float(self.frequency[ends[widest] - 1]),
        )

    @property
    def error(self) -> Array:
        """Standard deviation of |value| as a share of it, shape (n,).

        Bendat and Piersol (2010), eq. 9.90: sqrt(1 - g2) / (|g| sqrt(2 n)).
        """
        known = np.clip(self.coherence, 1e-12, 1.0)
        return np.asarray(np.sqrt((1.0 - known) / (2.0 * known * self.averages)))


def empirical_response(
    sources: Sequence[Array],
    signals: Sequence[Array],
    spacing: float,
    highest: float = math.inf,
) -> Response | None:
    """Estimate a response from several runs; None where they are too short or nothing moves.

    Parameters
    ----------
    sources, signals : sequence of ndarray, shape (n_rows of that run,)
        One array a run, sampled together.
    spacing : float
        [s] Between rows.
    highest : float
        [Hz] Half the rate at which the slower of the two was sampled, if that is slower than the
        rows: above it there is only what interpolation makes.
    """
    rows = int(min(column.size for column in sources) / _SEGMENTS)
    if rows < _LEAST_ROWS or not any(np.ptp(column) > 0.0 for column in sources):
        return None
    window = hann(rows, sym=False)
    xx, yy, xy = np.zeros(rows // 2 + 1), np.zeros(rows // 2 + 1), np.zeros(rows // 2 + 1, complex)
    for source, signal in zip(sources, signals, strict=True):
        # Differences of both have the same ratio, and leak less from a drift into other lines.
        x, y = (_spectra(np.diff(column), window) for column in (source, signal))
        xx += np.sum(np.abs(x) ** 2, axis=0)
        yy += np.sum(np.abs(y) ** 2, axis=0)
        xy += np.sum(np.conj(x) * y, axis=0)
    frequency = np.fft.rfftfreq(rows, spacing).astype(np.float64)
    excited = (frequency > 0.0) & (xx > _EXCITED * np.max(xx)) & (yy > 0.0)
    excited &= frequency <= highest
    if not excited.any():
        return None
    value = np.asarray(xy[excited] / xx[excited], dtype=np.complex128)
    coherence = np.abs(xy[excited]) ** 2 / (xx[excited] * yy[excited])
    averages = sum(column.size for column in sources) / rows
    return Response(frequency[excited], value, np.asarray(coherence, dtype=np.float64), averages)


def _spectra(column: Array, window: Array) -> NDArray[np.complex128]:
    """Spectra of half-overlapping segments without their trend, shape (n_segments, n_bins)."""
    rows = window.size
    starts = range(0, column.size - rows + 1, rows // 2)
    segments = np.stack([detrend(column[start : start + rows]) for start in starts])
    return np.asarray(np.fft.rfft(segments * window), dtype=np.complex128)
