"""Step of a parabola within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bounded_step(
    matrix: Array, slope: Array, free: NDArray[np.bool_], lowest: Array, highest: Array
) -> Array:
    """Newton step that goes to its first bound, and on from there with what is still free.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Curvature of the parabola, positive definite.
    slope : ndarray, shape (n,)
        Downhill.
    free : ndarray of bool, shape (n,)
        What may move.
    lowest, highest : ndarray, shape (n,)
        Ends of the step.

    Returns
    -------
    ndarray, shape (n,)
    """
    step, free = np.zeros(slope.size), free.copy()
    for _ in range(slope.size):
        rest = slope[free] - matrix[np.ix_(free, ~free)] @ step[~free]
        way = np.zeros(slope.size)
        way[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest) - step[free]
        room, ahead = np.full(slope.size, np.inf), np.where(way > 0.0, highest, lowest) - step
        with np.errstate(over="ignore"):  # of a way that is next to nothing
            np.divide(ahead, way, room, where=way != 0.0)
        # What meets a bound stops there, and the others make the best of it.
        step += way * min(1.0, room.min())
        if room.min() >= 1.0:
            break
        free &= room > room.min()
    return np.clip(step, lowest, highest)
