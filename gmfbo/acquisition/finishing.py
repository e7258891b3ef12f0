r"""Probability that a run of the axis finishes: that it stays inside the envelope and settles.

Whether a run finishes is a class, not a number, and a failed run has no objective that could be
modelled. So the objective is learned from finished runs alone, and a Gaussian process classifier
(Rasmussen and Williams 2006, Gaussian processes for machine learning, sections 3.4 and 3.9:
Laplace's approximation, probit likelihood) tells where runs finish:

    P(finishes at k) = Phi(f(k)),   f ~ GP(m(k), s^2 Matern-5/2(|k - k'| / l))

m is the belief before any run near k: that of the twin where it was run there, else the share of
finished runs by the rule of succession. l is the likeliest of a few. Expected improvement times
this probability is what is maximised (Gelbart, Snoek and Adams 2014), and after the first failure
only gains count that finish with a probability of at least 0.9::

    model = FinishModel.fit(points (n, d), finished (n,))
    search = Search(dimension=2, log_weight=model)           # log probability
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.special import log_ndtr, ndtri
from torch import Tensor

from gmfbo.correction.matern import matern52

LEAST_PROBABILITY = 0.9
"""Probability of finishing that a real run must have once a run has failed."""

TWIN_BELIEVED = 0.95
"""Probability of finishing by the word of a twin alone: enough for a real run, until a real run
nearby contradicts it."""

DEVIATION = 3.0
"""Prior standard deviation s of f: at given gains an axis fails nearly always or nearly never."""

# Lengthscales over the unit cube, and the log-normal prior on them, as for the corrected twin.
_LENGTHSCALES = (0.1, 0.2, 0.4, 0.8, 1.6)
_LENGTHSCALE_PRIOR = (0.4, 0.7)
_NEWTON_STEPS = 50
_CONVERGED = 1e-9


def prior_of(probability: ArrayLike) -> NDArray[np.float64]:
    """Prior mean m of f at which a run finishes with a probability in (0, 1), shape (...)."""
    return np.asarray(ndtri(np.asarray(probability, dtype=float)) * math.hypot(1.0, DEVIATION))


@dataclass(frozen=True, eq=False)
class FinishModel:
    """Posterior of f, from runs that finished and runs that did not.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Gains of the runs in the unit cube.
    elsewhere : float
        Prior mean m where no other is given.
    lengthscale : float
        l, over the unit cube.
    """

    points: NDArray[np.float64]
    elsewhere: float
    lengthscale: float
    _gradient: NDArray[np.float64]
    _root: NDArray[np.float64]
    _factor: NDArray[np.float64]

    @classmethod
    def fit(
        cls,
        points: NDArray[np.float64],
        finished: NDArray[np.bool_],
        prior: NDArray[np.float64] | None = None,
    ) -> Self:
        """Fit the classifier.

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Gains in the unit cube, of at least one run.
        finished : ndarray of bool, shape (n,)
            Whether each run finished.
        prior : ndarray, shape (n,), optional
            Prior mean m at the points.
        """
        signs = np.where(finished, 1.0, -1.0)
        elsewhere = float(prior_of((np.sum(finished) + 1.0) / (len(points) + 2.0)))
        mean = np.full(len(points), elsewhere) if prior is None else prior
        middle, spread = _LENGTHSCALE_PRIOR
        best: tuple[float, float, tuple[NDArray[np.float64], ...]] | None = None
        for length in _LENGTHSCALES:
            loss, parts = _laplace(points, signs, mean, length)
            loss += 0.5 * (np.log(length / middle) / spread) ** 2
            if best is None or loss < best[0]:
                best = loss, length, parts
        assert best is not None
        return cls(points, elsewhere, best[1], *best[2])

    def log_probability(
        self, points: NDArray[np.float64], prior: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Log probability of finishing, shape (q,), at points of the unit cube, shape (q, d).

        Parameters
        ----------
        points : ndarray, shape (q, d)
            Gains in the unit cube.
        prior : ndarray, shape (q,), optional
            Prior mean m there.
        """
        mean = self.elsewhere if prior is None else prior
        across = DEVIATION**2 * matern52(self.points, points, self.lengthscale)
        mean = mean + across.T @ self._gradient
        half = solve_triangular(self._factor, self._root[:, None] * across, lower=True)
        variance = DEVIATION**2 - np.sum(half**2, axis=0)
        return np.asarray(log_ndtr(mean / np.sqrt(1.0 + np.maximum(variance, 0.0))))

    def __call__(self, points: Tensor) -> Tensor:
        """As `log_probability` with the common prior mean, differentiable."""
        runs = torch.as_tensor(self.points, dtype=points.dtype)
        # The square root has no gradient at zero distance.
        square = (points[..., None, :] - runs).square().sum(dim=-1).clamp_min(1e-24)
        r = math.sqrt(5.0) * square.sqrt() / self.lengthscale
        across = DEVIATION**2 * (1.0 + r + r.square() / 3.0) * torch.exp(-r)
        mean = self.elsewhere + across @ torch.as_tensor(self._gradient, dtype=points.dtype)
        weighed = across * torch.as_tensor(self._root, dtype=points.dtype)
        factor = torch.as_tensor(self._factor, dtype=points.dtype)
        half = torch.linalg.solve_triangular(factor, weighed.mT, upper=False)
        variance = (DEVIATION**2 - half.square().sum(dim=0)).clamp_min(0.0)
        return torch.special.log_ndtr(mean / (1.0 + variance).sqrt())


def probable(log_probability: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which gains finish with a probability of at least 0.9, or nearly the largest there is.

    Parameters
    ----------
    log_probability : ndarray, shape (q,)
        Of finishing; where none reaches 0.9, gains within nine tenths of the largest count.
    """
    if len(log_probability) == 0:
        return np.zeros(0, dtype=bool)
    least, largest = math.log(LEAST_PROBABILITY), float(log_probability.max())
    return np.asarray(log_probability >= (least if largest >= least else largest + least))


def _laplace(
    points: NDArray[np.float64],
    signs: NDArray[np.float64],
    mean: NDArray[np.float64],
    lengthscale: float,
) -> tuple[float, tuple[NDArray[np.float64], ...]]:
    """Negative log evidence, and gradient, root of W and factor at the mode (algorithm 3.1)."""
    covariance = DEVIATION**2 * matern52(points, points, lengthscale)
    covariance += 1e-9 * np.eye(len(points))
    latent, last = np.zeros(len(points)), -np.inf
    for _ in range(_NEWTON_STEPS):
        gradient, weight = _derivatives(signs, mean + latent)
        root = np.sqrt(weight)
        factor = cholesky(np.eye(len(points)) + np.outer(root, root) * covariance, lower=True)
        right = weight * latent + gradient
        half = solve_triangular(factor, root * (covariance @ right), lower=True)
        solved = right - root * solve_triangular(factor.T, half, lower=False)
        latent = covariance @ solved
        evidence = float(-0.5 * solved @ latent + log_ndtr(signs * (mean + latent)).sum())
        if abs(evidence - last) < _CONVERGED:
            break
        last = evidence
    gradient, weight = _derivatives(signs, mean + latent)
    root = np.sqrt(weight)
    factor = cholesky(np.eye(len(points)) + np.outer(root, root) * covariance, lower=True)
    return float(np.log(np.diag(factor)).sum()) - evidence, (gradient, root, factor)


def _derivatives(
    signs: NDArray[np.float64], latent: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gradient of the log likelihood over f, and its negative curvature W, each shape (n,)."""
    along = signs * latent
    ratio = np.exp(-0.5 * along**2 - 0.5 * np.log(2.0 * np.pi) - log_ndtr(along))
    return signs * ratio, np.maximum(ratio * (ratio + along), 1e-12)
