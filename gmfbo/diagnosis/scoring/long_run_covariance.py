"""Covariance of sums over rows that are correlated in time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def long_run_covariance(score: Array) -> Array:
    """Covariance of the sum of correlated rows (Newey, West 1987), shape (n, n).

    Parameters
    ----------
    score : ndarray, shape (n, rows)
        Terms of n sums, each of mean zero.
    """
    rows = score.shape[1]
    lags = round(np.sqrt(rows))
    covariance: Array = score @ score.T
    for lag in range(1, min(lags, rows - 1) + 1):
        shifted = score[:, lag:] @ score[:, :-lag].T
        covariance += (1.0 - lag / (lags + 1.0)) * (shifted + shifted.T)
    return covariance
