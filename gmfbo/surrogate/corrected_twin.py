"""Surrogate of the axis whose prior mean is the objective of the corrected twin.

The objective g is a known function of a trajectory, and jumps where a response just enters or
leaves the settling band; trajectories do not jump. So the twin is corrected at the level of
trajectories, y(t; k) = y_twin(t; k) + residual(t; k), the objective of that is the prior mean
m(k), and a Gaussian process on g - m carries what is left (Kennedy and O'Hagan 2001, with the
discrepancy modelled before the objective and not after it)::

    runs = AxisRuns(points (n, d), values (n,), simulated (n, m), measured (n, m))
    model = CorrectedTwinModel.fit(runs, cost_of)            # cost_of: (q, m) -> (q,)
    mean, variance = model.predict(points (q, d), simulated (q, m))          # [g], [g^2]
    score = log_improvement(mean, variance, runs.values.min())   # gmfbo.acquisition.improvement

`simulated` is the twin at these points: run there, or interpolated from a survey of the box by
`ResidualProcess.fit(survey_points, survey_trajectories, centred=True).mean(points)`.

How far the prior mean can be trusted is measured, not assumed: each run of the axis is predicted
from the others, and the median error of g is the scale of the process. A twin that misleads
makes that error large, and the search then spreads over the box as a single-source one does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.spatial.distance import cdist

from gmfbo.correction.residual_process import ResidualProcess
from gmfbo.errors import InputError

CostOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]

# Lengthscale of g - m in the unit cube. The cost jumps, so little is learned far from a run; on
# drives with weak to gross twin errors 0.1 to 0.3 needed the same number of runs, and 0.3 and
# more stalled with the grossest.
DEPARTURE_LENGTHSCALE = 0.15
# Share of the scale that a repeated run may differ by.
NUGGET = 1e-4
# Least scale, as a share of the spread of the observed objectives: with a perfect twin the
# measured error is zero, and improvement would be decided by rounding.
LEAST_SCALE = 1e-3


@dataclass(frozen=True, eq=False)
class AxisRuns:
    """Runs of the axis, and of the twin at the same gains, at the same times.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Gains in the unit cube.
    values : ndarray, shape (n,)
        Objective g, to be minimised; a failed run has its price.
    simulated, measured : ndarray, shape (n, m)
        [signal] Trajectories; a row of NaN in either where that run failed.
    """

    points: NDArray[np.float64]
    values: NDArray[np.float64]
    simulated: NDArray[np.float64]
    measured: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("points", "values", "simulated", "measured"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
        count = len(self.values)
        if self.points.ndim != 2 or len(self.points) != count or count == 0:
            raise InputError(
                f"expected points of shape (n, d) with n = {count} values and n > 0, "
                f"got {self.points.shape}"
            )
        if self.simulated.shape != self.measured.shape or len(self.measured) != count:
            raise InputError(
                f"expected simulated and measured trajectories of one shape (n, m), n = {count}, "
                f"got {self.simulated.shape} and {self.measured.shape}"
            )
        if not np.all(np.isfinite(self.values)):
            raise InputError("objectives hold NaN or infinity; price a failed run first")

    @property
    def paired(self) -> NDArray[np.bool_]:
        """Runs of which both trajectories are whole, shape (n,)."""
        whole = np.isfinite(self.simulated) & np.isfinite(self.measured)
        return np.asarray(whole.all(axis=1))


@dataclass(frozen=True, eq=False)
class CorrectedTwinModel:
    """Normal posterior of g at gains where the twin's trajectory is known.

    Attributes
    ----------
    runs : AxisRuns
        What it was fitted to.
    cost_of : callable
        From trajectories, shape (q, m), to g, shape (q,).
    residual : ResidualProcess or None
        Of measured minus simulated trajectories; None while no run has both.
    scale : float
        [g] Prior standard deviation of g - m, from predicting each run by the others.
    """

    runs: AxisRuns
    cost_of: CostOf
    residual: ResidualProcess | None
    scale: float
    _factor: NDArray[np.float64]
    _white: NDArray[np.float64]

    @classmethod
    def fit(cls, runs: AxisRuns, cost_of: CostOf) -> Self:
        """Fit the residual, measure its error by leaving runs out, and condition on all runs.

        Parameters
        ----------
        runs : AxisRuns
            At least one.
        cost_of : callable
            From trajectories, shape (q, m), to g, shape (q,).
        """
        paired = runs.paired
        points, residuals = runs.points[paired], (runs.measured - runs.simulated)[paired]
        residual = ResidualProcess.fit(points, residuals) if paired.any() else None
        spread = float(np.ptp(runs.values)) or 1.0
        errors = _left_out_errors(runs, cost_of)
        scale = float(np.median(np.abs(errors))) if len(errors) else spread
        covariance = _matern52(runs.points, runs.points) + NUGGET * np.eye(len(runs.points))
        factor = cholesky(covariance, lower=True)
        departures = runs.values - _prior_mean(runs.points, runs.simulated, residual, cost_of)
        white = solve_triangular(factor, departures, lower=True)
        return cls(runs, cost_of, residual, max(scale, LEAST_SCALE * spread), factor, white)

    def trajectory(self, points: ArrayLike, simulated: ArrayLike) -> NDArray[np.float64]:
        """Expected trajectory of the axis [signal], shape (q, m); arguments as for `predict`."""
        return _corrected(np.asarray(points), np.asarray(simulated), self.residual)

    def predict(
        self, points: ArrayLike, simulated: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Posterior of the axis' objective.

        Parameters
        ----------
        points : array_like, shape (q, d)
            Gains in the unit cube.
        simulated : array_like, shape (q, m)
            [signal] The twin's trajectories there, at the times of the runs.

        Returns
        -------
        mean : ndarray, shape (q,)
            [g]
        variance : ndarray, shape (q,)
            [g^2]
        """
        where, twin = np.asarray(points, dtype=float), np.asarray(simulated, dtype=float)
        half = solve_triangular(self._factor, _matern52(self.runs.points, where), lower=True)
        mean = _prior_mean(where, twin, self.residual, self.cost_of) + half.T @ self._white
        variance = self.scale**2 * np.clip(1.0 - np.sum(half**2, axis=0), 0.0, 1.0)
        return mean, variance


def _corrected(
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    residual: ResidualProcess | None,
) -> NDArray[np.float64]:
    return simulated if residual is None else simulated + residual.mean(points)


def _prior_mean(
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    residual: ResidualProcess | None,
    cost_of: CostOf,
) -> NDArray[np.float64]:
    return np.asarray(cost_of(_corrected(points, simulated, residual)), dtype=float)


def _left_out_errors(runs: AxisRuns, cost_of: CostOf) -> NDArray[np.float64]:
    """Objective of each paired run minus its prediction from the other paired runs [g]."""
    rows = np.flatnonzero(runs.paired)
    residuals = runs.measured - runs.simulated
    predicted = []
    for row in rows:
        others = rows[rows != row]
        residual = (
            ResidualProcess.fit(runs.points[others], residuals[others]) if len(others) else None
        )
        predicted.append(_corrected(runs.points[[row]], runs.simulated[[row]], residual)[0])
    if not predicted:
        return np.empty(0)
    return runs.values[rows] - np.asarray(cost_of(np.array(predicted)), dtype=float)


def _matern52(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    r = np.sqrt(5.0) * cdist(one, other) / DEPARTURE_LENGTHSCALE
    return np.asarray((1.0 + r + r**2 / 3.0) * np.exp(-r))
