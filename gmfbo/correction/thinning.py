"""Choose the samples of a trajectory on which a Gaussian process is trained."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def thin(
    time: NDArray[np.float64],
    simulated: NDArray[np.float64],
    measured: NDArray[np.float64],
    count: int,
) -> NDArray[np.intp]:
    """Choose samples, denser where the response or its error changes.

    Samples lie at equal steps of a path length that consists in equal parts of time, of the path
    of the simulated signal, and of the path of its error, each relative to its total.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s]
    simulated, measured : ndarray, shape (n,)
        Signal of the twin and of the axis at these times.
    count : int
        Number of samples wanted, at least two.

    Returns
    -------
    ndarray of int, shape (at most count,)
        Increasing indices; the first and last sample are always among them.
    """
    if len(time) <= count:
        return np.arange(len(time))
    length = np.zeros(len(time))
    for signal in (time, simulated, _smooth(measured - simulated)):
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(signal)))])
        if way[-1] > 0.0:
            length += way / way[-1]
    chosen = np.searchsorted(length, np.linspace(0.0, length[-1], count))
    return np.unique(np.clip(chosen, 0, len(time) - 1))


def _smooth(error: NDArray[np.float64]) -> NDArray[np.float64]:
    # Without smoothing, the steps of a quantised sensor would count as change.
    width = max(1, len(error) // 100)
    padded = np.pad(error, (width // 2, width - 1 - width // 2), mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
