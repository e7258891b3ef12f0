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
from scipy.signal import detrend, fftconvolve
from scipy.signal.windows import hann

from gmfbo.diagnosis.runs.quantum import resolution

Array = NDArray[np.float64]

TRUSTED_COHERENCE = 0.8
"""Below it, the reference does not cause more than a fifth of a signal's power."""

_SEGMENTS = 3.0  # of the shortest recording; half of each overlaps with the next
_LEAST_ROWS = 32


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
    held = 0.5 / (highest * spacing) if math.isfinite(highest) else 1.0
    spurious = _leaked(xx) + _rounded(sources, window, held)
    excited = (frequency > 0.0) & (frequency <= highest) & (yy > 0.0)
    excited &= spurious < (1.0 - TRUSTED_COHERENCE) * xx
    if not excited.any():
        return None
    value = np.asarray(xy[excited] / xx[excited], dtype=np.complex128)
    coherence = np.abs(xy[excited]) ** 2 / (xx[excited] * yy[excited])
    averages = sum(column.size for column in sources) / rows
    return Response(frequency[excited], value, np.asarray(coherence, dtype=np.float64), averages)


def _leaked(power: Array) -> Array:
    """Power that the window makes in each bin of lines at least two bins away, at most.

    The transform of a Hann window at a distance of n bins is below 1 / (pi n (n^2 - 1)) of its
    peak (Harris 1978, eq. 26). A line lies up to half a bin beside the bin that shows it.
    """
    distance = np.arange(2.0, 2.0 * power.size) - 0.5
    side = (np.pi * distance * (distance**2 - 1.0)) ** -2
    kernel = np.concatenate([side[::-1], np.zeros(3), side])
    both = np.concatenate(
        [power[:0:-1], power]
    )  # a slow line leaks from its negative frequency too
    leaked = np.asarray(fftconvolve(both, kernel, "same")[power.size - 1 :], dtype=np.float64)
    return leaked + float(np.finfo(float).eps) * float(np.sum(both))  # the convolution's rounding


def _rounded(sources: Sequence[Array], window: Array, held: float) -> Array:
    """Power that the rounding of the recorded source makes in each bin.

    `held` is the number of rows for which the source holds one sample, and with it its error.
    """
    rows = window.size
    steps = 2.0 * np.sin(np.pi * np.arange(rows // 2 + 1) / rows)
    white = sum(
        resolution(column) ** 2 / 12.0 * ((column.size - 1 - rows) // (rows // 2) + 1)
        for column in sources
    )
    return np.asarray(held * white * float(np.sum(window**2)) * steps**2)


def _spectra(column: Array, window: Array) -> NDArray[np.complex128]:
    """Spectra of half-overlapping segments without their trend, shape (n_segments, n_bins)."""
    rows = window.size
    starts = range(0, column.size - rows + 1, rows // 2)
    segments = np.stack([detrend(column[start : start + rows]) for start in starts])
    return np.asarray(np.fft.rfft(segments * window), dtype=np.complex128)
