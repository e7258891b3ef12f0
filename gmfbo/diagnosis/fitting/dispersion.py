"""Dispersion: factor by which residuals of the best model exceed the error budget."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.scoring.whitening import Whitener

_LOWEST_HZ = 0.7


def dispersion_of(fitted: Fitted, whiteners: Sequence[Whitener]) -> list[NDArray[np.float64]]:
    """Mean square of each whitened component by half octave, at least 1, pooled over windows.

    An effect is named for its gain relative to the residual of the best model. No law is exact:
    the right family left 1.3 to 16 times the noise.

    Parameters
    ----------
    fitted : Fitted
        The best model, whitened without any dispersion.
    whiteners : sequence of Whitener
        Of its windows.

    Returns
    -------
    list of ndarray, shape (n_bins, n_signals)
    """
    names = sorted({w.window.n_signals for w in whiteners})
    found: list[NDArray[np.float64]] = [np.empty(0)] * len(whiteners)
    for count in names:
        chosen = [i for i, w in enumerate(whiteners) if w.window.n_signals == count]
        pooled = _pooled([(fitted.residual[i], whiteners[i]) for i in chosen])
        for i in chosen:
            band = _bands(whiteners[i].window.frequencies)
            found[i] = np.array([pooled[o] for o in band])
    return [
        spread * _of_window(residual, whitener, spread)
        for residual, whitener, spread in zip(fitted.residual, whiteners, found, strict=True)
    ]


def _pooled(
    parts: Sequence[tuple[NDArray[np.float64], Whitener]],
) -> dict[int, NDArray[np.float64]]:
    total: dict[int, NDArray[np.float64]] = {}
    count: dict[int, NDArray[np.float64]] = {}
    for residual, whitener in parts:
        power, seen = _power(residual, whitener)
        band = _bands(whitener.window.frequencies)
        for o in np.unique(band):
            rows = band == o
            total[o] = total.get(o, 0.0) + power[rows].sum(axis=0)
            count[o] = count.get(o, 0.0) + seen[rows].sum(axis=0)
    return {o: np.maximum(1.0, total[o] / np.maximum(count[o], 1.0)) for o in total}


def _power(
    residual: NDArray[np.float64], whitener: Whitener
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squares and degrees of freedom of each component, shape (n_bins, n_signals)."""
    seen = whitener.window.seen
    m, inner = whitener.window.n_signals, int(seen[1:].sum())
    power, degrees = np.zeros(seen.shape), np.where(seen, 2.0, 0.0)
    power[0], degrees[0] = residual[:m] ** 2, 1.0
    rest = np.zeros((seen.shape[0] - 1, m))
    rest[seen[1:]] = residual[m : m + inner] ** 2 + residual[m + inner :] ** 2
    power[1:] = rest
    return power, degrees


def _of_window(
    residual: NDArray[np.float64], whitener: Whitener, spread: NDArray[np.float64]
) -> float:
    """Factor by which one window exceeds the dispersion common to all, at least 1."""
    power, degrees = _power(residual, whitener)
    return max(1.0, float(np.sum(power / spread) / np.sum(degrees)))


def _bands(frequencies: NDArray[np.float64]) -> NDArray[np.int64]:
    """Half-octave bands from 0.7 Hz: 0, 1 and 2 Hz lie apart, since drifts are steep there."""
    bands: NDArray[np.int64] = np.floor(
        2.0 * np.log2(np.maximum(frequencies, _LOWEST_HZ) / _LOWEST_HZ)
    ).astype(int)
    return bands
