"""Low-pass without delay, for responses that are scored despite noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solveh_banded


def smoothed(time: ArrayLike, response: ArrayLike, time_constant: float) -> NDArray[np.float64]:
    """First-order low-pass run forward and backward, so that it delays nothing.

    y - T^2 y'' = x with y' = 0 at both ends, in finite volumes about the samples, whose spacing
    may vary. This is the low-pass 1 / (1 + T s) applied in both directions of time: a constant
    stays, the mean over time stays, and no value lies beyond the largest and smallest of x.

    Parameters
    ----------
    time : array_like, shape (n,)
        [s], increasing.
    response : array_like, shape (..., n)
        Signal of each run; a run with a non-finite sample stays as it is.
    time_constant : float
        [s] T; zero leaves all as it is.

    Returns
    -------
    ndarray, shape (..., n)
        [unit of the response]
    """
    times, values = np.asarray(time, dtype=float), np.asarray(response, dtype=float)
    if time_constant == 0.0 or times.size < 3:
        return values
    gaps = np.diff(times)
    width = 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps))
    flow = time_constant**2 / gaps
    bands = np.zeros((2, times.size))
    bands[0, 1:] = -flow
    bands[1] = width + np.append(flow, 0.0) + np.append(0.0, flow)
    flat = values.reshape(-1, times.size)
    finite = np.isfinite(flat).all(axis=1)
    kept = flat.copy()
    if finite.any():
        kept[finite] = solveh_banded(bands, width[:, None] * flat[finite].T).T
    return kept.reshape(values.shape)
