"""Surrogate of the axis whose prior mean is the expected objective of the corrected twin.

The objective g is a known function of a trajectory. It jumps where a response just enters or leaves
the settling band, whereas trajectories do not jump. So the twin's trajectories are corrected,
y(t; k) = y_twin(t; k) + residual(t; k). The objective that is expected of them is the prior mean
m(k) (Astudillo and Frazier 2019, Bayesian optimization of composite functions), and a Gaussian
process models the rest g - m (Kennedy and O'Hagan 2001, here with the discrepancy before the
objective and not after it)::

    runs = AxisRuns(points (n, d), values (n,), simulated (n, m), measured (n, m))
    model = CorrectedTwinModel.fit(runs, cost_of)            # cost_of: (q, m) -> (q,)
    mean, variance = model.predict(points (q, d), simulated (q, m))          # [g], [g^2]
    score = log_improvement(mean, variance, runs.values.min())   # gmfbo.acquisition.improvement

`simulated` is the twin at these points: run there, or interpolated from a survey of the box by
a `ResidualProcess` of the survey's trajectories, `centred=True`, with `likeliest_smoothness`.

The accuracy of the prior mean is measured: each run of the axis is predicted from the others, and
the median error of g is the scale of the process. A misleading twin makes that error large, and the
search then spreads over the box as a single-source search does.

An axis does not repeat itself exactly: friction and noise differ from run to run. What neighbouring
runs do not share is noise, in the trajectories as in the objective, and its size is the likeliest
one (Gramacy and Lee 2012, Cases for the nugget in modeling computer experiments). Without it the
luckiest run would be believed. Where the objective jumps, the mean over trajectories with that
noise differs from the objective of their mean, and is what counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, solve_triangular

from gmfbo.correction.matern import matern52
from gmfbo.surrogate.axis_residual import AxisRuns, CostOf, Residual, mean_cost
from gmfbo.surrogate.smoothness import LEAST_TOLD, REPEATED, Smoothness

# Lengthscale of g - m in the unit cube. The cost jumps, so a run tells little about far gains. On
# drives with weak to gross twin errors, 0.1 to 0.3 needed the same number of runs; 0.3 and more
# stalled with the grossest error.
DEPARTURE_LENGTHSCALE = 0.15
# Candidates for the noise variance of a repeated run, over that of g - m. Runs that lie together
# tell nothing of a departure further away, which is taken to be as large as their noise at least.
REPEATED_COST = tuple(one for one in REPEATED if one <= 1.0)
# Times the median deviation from which a run is an outlier: three standard deviations.
_OUTLYING = 4.5
# Log-likelihood by which noise must explain errors better than none (Akaike 1974: a parameter).
NOISE_COSTS = 1.0
# Least scale, as a share of the spread of the observed objectives: with a perfect twin the
# measured error is zero, and improvement would be decided by rounding.
LEAST_SCALE = 1e-3


@dataclass(frozen=True, eq=False)
class CorrectedTwinModel:
    """Normal posterior of g at gains where the twin's trajectory is known.

    Attributes
    ----------
    runs : AxisRuns
        Runs of the fit.
    cost_of : callable
        From trajectories, shape (q, m), to g, shape (q,).
    residual : Residual
        Of measured minus simulated trajectories; zero while no run has both.
    scale : float
        [g] Prior standard deviation of g - m: the median error of predicting each run by the
        others, or the spread of the observed costs while there is no such error.
    noise : float
        [g] Standard deviation of a repeated run.
    offset : float
        [g] What all runs cost beyond the corrected twin, as by noise that the twin has not: it
        tells nothing of where to go, and is part of the prior mean. Zero for fewer than four runs.
    unknown : float
        [g] Prior mean where the twin has no trajectory: the median of the runs.
    """

    runs: AxisRuns
    cost_of: CostOf
    residual: Residual
    scale: float
    noise: float
    offset: float
    unknown: float
    _factor: NDArray[np.float64]
    _white: NDArray[np.float64]

    @classmethod
    def fit(cls, runs: AxisRuns, cost_of: CostOf, noise: float = 0.0) -> Self:
        """Fit the residual, measure its error by leaving runs out, and condition on all runs.

        Parameters
        ----------
        runs : AxisRuns
            At least one.
        cost_of : callable
            From trajectories, shape (q, m), to g, shape (q,).
        noise : float
            [g] Least standard deviation of the cost of repeated runs.
        """
        rows = np.flatnonzero(runs.paired)
        smoothness = Residual.smoothness(runs, rows)
        residual = Residual.fit(runs, rows, smoothness)
        errors = _left_out_errors(runs, rows, cost_of, smoothness)
        scale, repeated = _scale_and_noise(runs, rows, errors, noise)
        everything = np.arange(len(runs.values))
        extra = runs.extra_of(everything) + repeated
        factor = cholesky(_covariance(runs.points, extra), lower=True)
        unknown = float(np.median(runs.values))
        prior = _prior_mean(runs.points, runs.simulated, residual, cost_of, unknown)
        left = runs.values - prior
        offset = _common(factor, left) if len(rows) >= LEAST_TOLD else 0.0
        white = solve_triangular(factor, (left - offset) / scale, lower=True)
        spread = scale * float(np.sqrt(repeated))
        return cls(runs, cost_of, residual, scale, spread, offset, unknown, factor, white)

    def trajectory(self, points: ArrayLike, simulated: ArrayLike) -> NDArray[np.float64]:
        """Expected trajectory of the axis [signal], shape (q, m); arguments as for `predict`."""
        return np.asarray(simulated) + self.residual.mean(np.asarray(points))

    def predict(
        self, points: ArrayLike, simulated: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Posterior of the axis' objective.

        Parameters
        ----------
        points : array_like, shape (q, d)
            Gains in the unit cube.
        simulated : array_like, shape (q, m)
            [signal] The twin's trajectories there, at the times of the runs; a row of NaN where it
            has none.

        Returns
        -------
        mean : ndarray, shape (q,)
            [g]
        variance : ndarray, shape (q,)
            [g^2]
        """
        where, twin = np.asarray(points, dtype=float), np.asarray(simulated, dtype=float)
        half = solve_triangular(
            self._factor, matern52(self.runs.points, where, DEPARTURE_LENGTHSCALE), lower=True
        )
        mean = _prior_mean(where, twin, self.residual, self.cost_of, self.unknown) + self.offset
        mean = mean + self.scale * (half.T @ self._white)
        variance = self.scale**2 * np.clip(1.0 - np.sum(half**2, axis=0), 0.0, 1.0)
        return mean, variance


def _prior_mean(
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    residual: Residual,
    cost_of: CostOf,
    unknown: float,
) -> NDArray[np.float64]:
    mean = np.full(len(points), unknown)
    known = np.isfinite(simulated).all(axis=1)
    if known.any():
        mean[known] = residual.expected_cost(points[known], simulated[known], cost_of)
    return mean


def _left_out_errors(
    runs: AxisRuns,
    rows: NDArray[np.intp],
    cost_of: CostOf,
    smoothness: tuple[Smoothness, Smoothness],
) -> NDArray[np.float64]:
    """Errors of predicting each of the paired runs from the others [g], shape (k,)."""
    if len(rows) == 0:
        return np.empty(0)
    predicted = []
    for row in rows:
        residual = Residual.fit(runs, rows[rows != row], smoothness)
        predicted.append(residual.repeats(runs.points[[row]], runs.simulated[[row]])[0])
    return np.asarray(runs.values[rows] - mean_cost(np.stack(predicted), cost_of))


def _scale_and_noise(
    runs: AxisRuns, rows: NDArray[np.intp], errors: NDArray[np.float64], noise: float
) -> tuple[float, float]:
    """Prior standard deviation of g - m [g], and the variance of a repeated run over its square.

    A run close to another one is predicted well by any twin. So each error is divided by the
    posterior standard deviation there, relative to the prior one. Errors that neighbours do not
    share are noise; its share is the likeliest one.
    """
    spread = float(np.ptp(runs.values)) or 1.0
    if not len(errors):
        return spread, (noise / spread) ** 2
    found: list[tuple[float, float, float]] = []
    candidates = REPEATED_COST if len(errors) >= LEAST_TOLD else REPEATED_COST[:1]
    for repeated in candidates:
        extra = runs.extra_of(rows) + repeated
        covariance = _covariance(runs.points[rows], extra)
        factor = cholesky(covariance, lower=True)
        about = errors - (_common(factor, errors) if len(errors) >= LEAST_TOLD else 0.0)
        size = float(np.mean(solve_triangular(factor, about, lower=True) ** 2))
        loss = 0.5 * len(errors) * np.log(size + np.finfo(float).tiny)
        loss += float(np.log(np.diag(factor)).sum()) + NOISE_COSTS * (repeated > REPEATED_COST[0])
        left = 1.0 / np.diag(np.linalg.inv(covariance))
        scale = float(np.median(np.abs(about) / np.sqrt(left)))
        found.append((float(loss), max(scale, LEAST_SCALE * spread), repeated))
    _, scale, repeated = min(found)
    # What is known of the noise from elsewhere is taken off what the twin seems to miss.
    total = scale**2 * (1.0 + repeated)
    scale = max(float(np.sqrt(max(min(scale**2, total - noise**2), 0.0))), LEAST_SCALE * spread)
    return scale, max(repeated, (noise / scale) ** 2)


def _common(factor: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Mean of correlated values by generalised least squares, from the factor of their covariance.

    Far outliers, as of runs that the twin cannot follow, are drawn to three standard deviations.
    """
    middle = float(np.median(values))
    reach = _OUTLYING * float(np.median(np.abs(values - middle)))
    drawn = np.clip(values, middle - reach, middle + reach)
    ones = solve_triangular(factor, np.ones(len(values)), lower=True)
    return float(ones @ solve_triangular(factor, drawn, lower=True) / (ones @ ones))


def _covariance(points: NDArray[np.float64], extra: NDArray[np.float64]) -> NDArray[np.float64]:
    own = matern52(points, points, DEPARTURE_LENGTHSCALE)
    return np.asarray(own + np.diag(extra))
