"""Matern covariance with smoothness 5/2 between points of the unit cube."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist


def matern52(
    one: NDArray[np.float64], other: NDArray[np.float64], lengthscale: float
) -> NDArray[np.float64]:
    """(1 + r + r^2 / 3) exp(-r) with r = sqrt(5) |k - k'| / lengthscale.

    Rasmussen and Williams 2006, Gaussian processes for machine learning, equation 4.17. The
    variance is 1.

    Parameters
    ----------
    one : ndarray, shape (n, d)
        Points of the unit cube.
    other : ndarray, shape (m, d)
        Points of the unit cube.
    lengthscale : float
        Over the unit cube.

    Returns
    -------
    ndarray, shape (n, m)
        Within (0, 1].
    """
    r = np.sqrt(5.0) * cdist(one, other) / lengthscale
    return np.asarray((1.0 + r + r**2 / 3.0) * np.exp(-r))
