r"""Change-point evidence: a function of the gains changed at some run, with bounded false alarms.

Value y_i of run i at gains k_i, in the order in which the runs were made:

    no change         y_i = m + f(k_i) + noise,   f ~ GP(0, s^2 Matern-5/2(|k - k'| / l))
    change after c    as above, plus [i > c] (a + h(k_i)),   var a = var h = rho^2 s^2 / 2

With noise variance g s^2, m and s integrated out under their invariant prior (1 / s), the ratio
of the two marginal likelihoods is a ratio of densities whatever m and s are (Harville 1974, for
one of them). l and g are not known. The numerator averages over a grid of them, and over rho; the
denominator takes the likeliest of the grid (universal inference, Wasserman, Ramdas and
Balakrishnan 2020). So the ratio has an expectation of at most 1 for each of them.

The ratios summed over all c are the statistic of Shiryaev (1963) and Roberts (1966). Without a
change its expectation after n runs is at most n - 1 and it is dominated by a submartingale, so
that (Doob)

    P(it reaches 1 / rate within n runs) <= n * rate.

The same holds for a mean of such statistics of several values of the runs, dependent or not.
The ratios consist of errors of one-step-ahead prediction: a run that earlier runs predict badly and
later runs well is evidence of a change between them. A differing repeat of the same gains is the
strongest evidence, as only noise can explain it otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.matern import matern52

FALSE_ALARM_RATE = 1.0 / 400.0
"""Most false alarms a run: at most 5 % of studies of 20 real runs of an unchanged plant."""

LEAST_BEFORE, LEAST_SINCE = 3, 2
"""Runs before and since a change that must bear it out: a single one may be an outlier, or lie
in a region of the gains where the axis behaves otherwise."""

LEAST_RUNS = 3
"""Fewest values for evidence: m and s take two."""

# Lengthscales over the unit square, which grow as its diagonal does in more dimensions.
_LENGTHSCALES = (0.15, 0.5, 2.0)
_NOISES = (1e-4, 1e-2, 1e-1, 1.0)
_RATIOS = (0.3, 3.0, 30.0)
# Larger than n over the least noise variance, so that the bordered matrix stays definite.
_BORDER = 1e9


@dataclass(frozen=True, eq=False)
class ChangeEvidence:
    """Evidence from the values of n runs for a change between them.

    Attributes
    ----------
    log_ratios : ndarray, shape (n - 1,)
        Natural logarithm of the ratio for a change after run 1 ... n - 1.
    shares : ndarray, shape (n - 1,)
        Expected rho^2, variance of the change over that of the values, given the change.
    """

    log_ratios: NDArray[np.float64]
    shares: NDArray[np.float64]

    @classmethod
    def of(cls, points: NDArray[np.float64], values: NDArray[np.float64]) -> ChangeEvidence:
        """Weigh a change after each of the runs.

        Parameters
        ----------
        points : ndarray, shape (n, d)
            Gains in the unit cube, in the order of the runs.
        values : ndarray, shape (n,)
            Any unit; ratios do not depend on it, nor on a constant added.
        """
        count = len(values)
        silent = cls(np.zeros(max(count - 1, 0)), np.ones(max(count - 1, 0)))
        spread = float(np.std(values)) if count else 0.0
        # Values that are all equal, up to rounding, carry no evidence.
        if count < LEAST_RUNS or spread <= 1e-12 * float(np.abs(values).max()):
            return silent
        scaled = (values - values.mean()) / spread
        smooth = _covariances(points.tobytes(), points.shape)
        noise = np.array(_NOISES)[:, None, None] * np.eye(count)
        unchanged = smooth[:, None] + noise
        best = _log_likelihood(unchanged, scaled).max()
        log_ratios, shares = np.empty(count - 1), np.empty(count - 1)
        for before in range(1, count):
            later = (np.arange(count) >= before).astype(float)
            jump = np.outer(later, later) * 0.5 * (1.0 + smooth)
            each = np.stack(
                [_log_likelihood(unchanged + r * jump[:, None], scaled) for r in _RATIOS]
            )
            total = float(np.logaddexp.reduce(each, axis=None))
            log_ratios[before - 1] = total - np.log(each.size) - best
            weights = np.exp(each - total).sum(axis=(1, 2))
            shares[before - 1] = float(weights @ np.array(_RATIOS))
        return cls(log_ratios, shares)


def combined(evidence: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Logarithm of the mean ratio over several values of the same runs, shape (n - 1,)."""
    return np.asarray(np.logaddexp.reduce(np.stack(evidence), axis=0) - np.log(len(evidence)))


def log_statistic(log_ratios: NDArray[np.float64]) -> float:
    """Logarithm of the Shiryaev-Roberts statistic; minus infinity while there is no ratio."""
    return float(np.logaddexp.reduce(log_ratios)) if len(log_ratios) else -np.inf


@lru_cache(maxsize=8)
def _covariances(content: bytes, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Matern covariance of the points for each lengthscale, shape (lengthscales, n, n)."""
    points = np.frombuffer(content).reshape(shape)
    diagonal = np.sqrt(shape[1] / 2.0)
    return np.stack([matern52(points, points, length * diagonal) for length in _LENGTHSCALES])


def _log_likelihood(
    covariance: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Marginal log likelihood, less a constant of n, for covariances of shape (..., n, n).

    Mean and scale are integrated out: with P = K^-1 - K^-1 1 1' K^-1 / (1' K^-1 1),
    -(log|K| + log(1' K^-1 1) + (n - 1) log(y' P y)) / 2.
    """
    count = len(values)
    # The Cholesky factor of [[K, S], [S', big]] holds L^-1 S in its lower rows, for S = [y, 1].
    bordered = np.empty((*covariance.shape[:-2], count + 2, count + 2))
    bordered[..., :count, :count] = covariance
    bordered[..., count, :count], bordered[..., count + 1, :count] = values, 1.0
    bordered[..., count:, count:] = _BORDER * np.eye(2)
    # Only the lower triangle is read.
    factor = np.linalg.cholesky(bordered)
    first, ones = factor[..., count, :count], factor[..., count + 1, :count]
    weight = np.sum(ones**2, axis=-1)
    left = np.sum(first**2, axis=-1) - np.sum(first * ones, axis=-1) ** 2 / weight
    left = np.maximum(left, np.finfo(float).tiny)
    diagonal = np.diagonal(factor, axis1=-2, axis2=-1)[..., :count]
    half_log_determinant = np.log(diagonal).sum(axis=-1)
    return np.asarray(
        -half_log_determinant - 0.5 * np.log(weight) - 0.5 * (count - 1) * np.log(left)
    )
