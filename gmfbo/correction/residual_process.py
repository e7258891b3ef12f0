"""Residual process: Gaussian process of the twin's error over whole trajectories.

The residual of run i, r_i(t) = y_real(t; k_i) - y_sim(t; k_i), is a function of time that changes
smoothly with the gains k. With a separable covariance c(k, k') S(t, t') (matrix normal
distribution, Dawid 1981) and one set of times for all runs, the posterior at new gains is

    mean  r(t; k) = c(k)' C^-1 R,        R of shape (runs, times),
    covariance    = (c(k, k) - c(k)' C^-1 c(k)) S,

so that one matrix of the size of the number of runs serves all times. S is estimated by its maximum
likelihood R' C^-1 R / n (Bonilla, Chai and Williams 2008, for tasks). With the twin's own
trajectories in place of residuals, the same process is an emulator of the twin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, cholesky, solve_triangular

from gmfbo.correction.matern import matern52

NUGGET = 1e-4
"""Variance of a run about its neighbourhood over that of the process: quantisation, friction."""


@dataclass(frozen=True, eq=False)
class ResidualProcess:
    """Posterior of functions of time over the gains.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Gains of the runs, scaled to the unit cube.
    lengthscale : float
        Of the Matern 5/2 covariance over the unit cube.
    """

    points: NDArray[np.float64]
    lengthscale: float
    _factor: NDArray[np.float64]
    _whitened: NDArray[np.float64]
    _centre: NDArray[np.float64]

    @classmethod
    def fit(
        cls,
        points: NDArray[np.float64],
        functions: NDArray[np.float64],
        *,
        lengthscale: float,
        centred: bool = False,
        extra: NDArray[np.float64] | None = None,
    ) -> Self:
        """Condition on functions of time, one a run.

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Gains in the unit cube.
        functions : ndarray, shape (n, m)
            Residual, or trajectory, at the same m times for each run [unit of the signal].
        lengthscale : float
            Over the unit cube.
        centred : bool
            Whether the posterior far from all runs is their mean instead of zero.
        extra : ndarray, shape (n,), optional
            Variance of a run beyond `NUGGET`, over that of the process, for runs from before the
            plant changed.

        Notes
        -----
        Without any run the residual is taken as zero, since nothing is known of its size.
        """
        if not len(points):
            return cls(points, lengthscale, np.eye(0), functions, np.zeros(functions.shape[1]))
        centre = functions.mean(axis=0) if centred else np.zeros(functions.shape[1])
        covariance = matern52(points, points, lengthscale) + NUGGET * np.eye(len(points))
        if extra is not None:
            covariance += np.diag(extra)
        factor = cholesky(covariance, lower=True)
        whitened = solve_triangular(factor, functions - centre, lower=True)
        return cls(points, lengthscale, factor, whitened, centre)

    def mean(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Posterior mean, shape (q, m), at points of the unit cube, shape (q, d)."""
        return self._centre + self._solved(points).T @ self._whitened

    def departures(self, variance: float, count: int) -> NDArray[np.float64]:
        """What the last runs did that their neighbours did not, shape (2 k, m), k <= count.

        Each is what is left of a run's function when it is predicted from all others, scaled so
        that its covariance is that of a repeated run, `variance` times S, and comes with its mirror
        image. What the process cannot follow over the gains is part of it. A run that differs
        grossly is one of them; draws from the estimated S would all be shaped by it.

        Parameters
        ----------
        variance : float
            Of a repeated run, over that of the process; part of what the process was fitted with.
        count : int
            Most runs.
        """
        inverse = cho_solve((self._factor, True), np.eye(len(self.points)))
        left = solve_triangular(self._factor, self._whitened, lower=True, trans="T")
        scale = np.sqrt(variance / np.diag(inverse))
        own = (scale[:, None] * left)[-count:]
        return np.concatenate([own, -own])

    def _solved(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        if not len(self.points):
            return np.zeros((0, len(points)))
        across = matern52(self.points, points, self.lengthscale)
        return np.asarray(solve_triangular(self._factor, across, lower=True))
