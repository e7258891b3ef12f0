"""How far the corrected twin may be off: measured by leaving real runs out, here and there.

A trust turns the errors of left-out runs into the prior standard deviation of the cost about the
corrected twin's, as a function of the gains. `uniform_trust` has one for the whole box;
`local_trust` is the input-dependent fidelity that the publication leaves for later: where
left-out runs were predicted badly, the surrogate expects more of what the twin does not say.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.matern import matern52

Trust = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""From points of the unit cube, shape (q, d), to standard deviations of g, shape (q,)."""

TrustOf = Callable[[NDArray[np.float64], NDArray[np.float64], float, float], Trust]
"""From points (n, d), errors of the runs left out there (n,), the spread of the observed costs
and the least standard deviation to a trust."""

LOCAL_LENGTHSCALE = 0.4
"""Of the mismatch over the unit cube; what a twin lacks changes more slowly than the cost."""


def uniform_trust(
    points: NDArray[np.float64], errors: NDArray[np.float64], spread: float, least: float
) -> Trust:
    """One standard deviation for all gains: the median error.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    errors : ndarray, shape (n,)
        [g] Of runs predicted from the others.
    spread : float
        [g] Of the observed costs; what is believed before any run was left out.
    least : float
        [g] Least standard deviation.
    """
    scale = max(float(np.median(np.abs(errors))) if len(errors) else spread, least)
    return lambda where: np.full(len(where), scale)


def local_trust(
    points: NDArray[np.float64], errors: NDArray[np.float64], spread: float, least: float
) -> Trust:
    """The mean square of the errors nearby, beside one error of the uniform size everywhere.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    errors : ndarray, shape (n,)
        [g] Of runs predicted from the others.
    spread : float
        [g] Of the observed costs.
    least : float
        [g] Least standard deviation.
    """
    uniform = uniform_trust(points, errors, spread, least)

    def trust(where: NDArray[np.float64]) -> NDArray[np.float64]:
        everywhere = uniform(where)
        if not len(errors):
            return everywhere
        near = matern52(where, points, LOCAL_LENGTHSCALE)
        squares = (everywhere**2 + near @ errors**2) / (1.0 + near.sum(axis=1))
        return np.asarray(np.maximum(np.sqrt(squares), least))

    return trust
