"""How smoothly functions of time change over the gains, and how well they repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from gmfbo.correction.matern import matern52
from gmfbo.correction.residual_process import NUGGET

# Candidates for the lengthscale over the gains, and the log-normal prior (median, spread).
LENGTHSCALES = (0.1, 0.2, 0.4, 0.8, 1.6)
_LENGTHSCALE_PRIOR = (0.4, 0.7)
# Variance of a repeated run, over that of the process: the least, and further candidates.
REPEATED = (NUGGET, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0)
# Fewest runs from which the noise of a repeated run is told from a change over the gains.
LEAST_TOLD = 4


@dataclass(frozen=True)
class Smoothness:
    """How residuals change over the gains.

    Attributes
    ----------
    lengthscale : float
        Over the unit cube.
    repeated : float
        Variance of a repeated run over that of the process.
    """

    lengthscale: float
    repeated: float


def likeliest_smoothness(
    points: NDArray[np.float64],
    functions: NDArray[np.float64],
    extra: NDArray[np.float64] | None = None,
    repeated: Sequence[float] = REPEATED,
) -> Smoothness:
    """Smoothness of functions of time over the gains, by marginal posterior.

    The scale of the functions is integrated out, and all times count as one observation in
    total: neighbouring samples of a trajectory are not independent.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    functions : ndarray, shape (n, m)
        One a point.
    extra : ndarray, shape (n,), optional
        As in `AxisRuns`.
    repeated : sequence of float
        Candidates for the variance of a repeated run; the first one alone for fewer than four runs.
    """
    median, spread = _LENGTHSCALE_PRIOR
    candidates = repeated if len(points) >= LEAST_TOLD else repeated[:1]
    found = [Smoothness(length, own) for own in candidates for length in LENGTHSCALES]
    losses = []
    for one in found:
        loss = 0.5 * (np.log(one.lengthscale / median) / spread) ** 2
        if len(points):
            covariance = matern52(points, points, one.lengthscale)
            covariance += one.repeated * np.eye(len(points))
            if extra is not None:
                covariance += np.diag(extra)
            factor = cholesky(covariance, lower=True)
            white = solve_triangular(factor, functions, lower=True)
            scale = float(np.mean(white**2)) + np.finfo(float).tiny
            loss += 0.5 * len(points) * np.log(scale) + float(np.log(np.diag(factor)).sum())
        losses.append(loss)
    return found[int(np.argmin(losses))]
