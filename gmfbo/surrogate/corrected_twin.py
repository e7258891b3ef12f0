"""Surrogate of the axis whose prior mean is the objective of the corrected twin.

The objective g is a known function of a trajectory. It jumps where a response just enters or leaves
the settling band, whereas trajectories do not jump. So the twin's trajectories are corrected,
y(t; k) = y_twin(t; k) + residual(t; k). Their objective is the prior mean m(k), and a Gaussian
process models the rest g - m (Kennedy and O'Hagan 2001, here with the discrepancy before the
objective and not after it)::

    runs = AxisRuns(points (n, d), values (n,), simulated (n, m), measured (n, m))
    model = CorrectedTwinModel.fit(runs, cost_of)            # cost_of: (q, m) -> (q,)
    mean, variance = model.predict(points (q, d), simulated (q, m))          # [g], [g^2]
    score = log_improvement(mean, variance, runs.values.min())   # gmfbo.acquisition.improvement

`simulated` is the twin at these points: run there, or interpolated from a survey of the box by
a `ResidualProcess` of the survey's trajectories, `centred=True`, with `likeliest_lengthscale`.

The accuracy of the prior mean is measured: each run of the axis is predicted from the others, and
the median error of g is the scale of the process. A misleading twin makes that error large, and the
search then spreads over the box as a single-source search does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, solve_triangular

from gmfbo.correction.matern import matern52
from gmfbo.correction.residual_process import ResidualProcess
from gmfbo.errors import InputError

CostOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]

# Lengthscale of g - m in the unit cube. The cost jumps, so a run tells little about far gains. On
# drives with weak to gross twin errors, 0.1 to 0.3 needed the same number of runs; 0.3 and more
# stalled with the grossest error.
DEPARTURE_LENGTHSCALE = 0.15
# Candidates for the residual over the gains, and the log-normal prior (median, spread).
LENGTHSCALES = (0.1, 0.2, 0.4, 0.8, 1.6)
_LENGTHSCALE_PRIOR = (0.4, 0.7)
# Noise variance of a repeated run, over the variance of the process.
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
        Objective g, to be minimised; that of a failed run is finite.
    simulated, measured : ndarray, shape (n, m)
        [signal] Trajectories; a row of NaN in either where that run failed.
    extra : ndarray, shape (n,), optional
        Extra noise variance of runs from before the plant changed, over the variance of the
        process. None is zero.
    beside : int
        Number of last columns of the trajectories that are no samples but single numbers of a run,
        each with a unit of its own: what counts in the objective and does not follow from the
        signal.
    """

    points: NDArray[np.float64]
    values: NDArray[np.float64]
    simulated: NDArray[np.float64]
    measured: NDArray[np.float64]
    extra: NDArray[np.float64] | None = None
    beside: int = 0

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

    def extra_of(self, rows: NDArray[np.generic]) -> NDArray[np.float64]:
        """Extra variance of some runs, given by a mask or indices."""
        return (np.zeros(len(self.values)) if self.extra is None else self.extra)[rows]

    @property
    def paired(self) -> NDArray[np.bool_]:
        """Mask of the runs with both trajectories, shape (n,)."""
        whole = np.isfinite(self.simulated) & np.isfinite(self.measured)
        return np.asarray(whole.all(axis=1))


@dataclass(frozen=True, eq=False)
class Residual:
    """Residual of a trajectory over the gains, and of the single numbers beside it.

    The numbers have units of their own, so that they get a lengthscale of their own.

    Attributes
    ----------
    of_samples : ResidualProcess
        Of the samples.
    of_numbers : ResidualProcess or None
        Of what lies beside them; None where nothing does.
    """

    of_samples: ResidualProcess
    of_numbers: ResidualProcess | None

    @staticmethod
    def lengthscales(runs: AxisRuns, rows: NDArray[np.intp]) -> tuple[float, float]:
        """Likeliest lengthscales of the samples and of the numbers.

        Parameters
        ----------
        runs : AxisRuns
            Runs of the axis.
        rows : ndarray of int, shape (k,)
            Which of them have both trajectories.
        """
        points, extra = runs.points[rows], runs.extra_of(rows)
        samples, numbers = _parts(runs, rows)
        spread = np.sqrt(np.mean(numbers**2, axis=0)) if len(numbers) else np.ones(runs.beside)
        scaled = numbers / np.where(spread > 0.0, spread, 1.0)
        return (
            likeliest_lengthscale(points, samples, extra),
            likeliest_lengthscale(points, scaled, extra) if runs.beside else 1.0,
        )

    @classmethod
    def fit(cls, runs: AxisRuns, rows: NDArray[np.intp], lengths: tuple[float, float]) -> Self:
        """Condition on some of the runs.

        Parameters
        ----------
        runs : AxisRuns
            Runs of the axis.
        rows : ndarray of int, shape (k,)
            Which of them count; they have both trajectories.
        lengths : tuple of float
            Lengthscales of the samples and of the numbers.
        """
        points, extra = runs.points[rows], runs.extra_of(rows)
        samples, numbers = _parts(runs, rows)
        of_samples = ResidualProcess.fit(points, samples, lengthscale=lengths[0], extra=extra)
        if not runs.beside:
            return cls(of_samples, None)
        of_numbers = ResidualProcess.fit(points, numbers, lengthscale=lengths[1], extra=extra)
        return cls(of_samples, of_numbers)

    def mean(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Posterior mean, shape (q, m), at points of the unit cube, shape (q, d)."""
        found = self.of_samples.mean(points)
        if self.of_numbers is None:
            return found
        return np.hstack([found, self.of_numbers.mean(points)])


def _parts(
    runs: AxisRuns, rows: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals of some runs: samples (k, m - beside), and numbers (k, beside)."""
    left = (runs.measured - runs.simulated)[rows]
    samples = left.shape[1] - runs.beside
    return left[:, :samples], left[:, samples:]


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
    unknown : float
        [g] Prior mean where the twin has no trajectory: the median of the runs.
    """

    runs: AxisRuns
    cost_of: CostOf
    residual: Residual
    scale: float
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
            [g] Standard deviation of the cost of repeated runs, beyond the nugget.
        """
        rows = np.flatnonzero(runs.paired)
        lengths = Residual.lengthscales(runs, rows)
        residual = Residual.fit(runs, rows, lengths)
        spread = float(np.ptp(runs.values)) or 1.0
        errors = _left_out_errors(runs, cost_of, lengths)
        scale = max(
            float(np.median(np.abs(errors))) if len(errors) else spread, LEAST_SCALE * spread
        )
        everything = np.arange(len(runs.values))
        extra = runs.extra_of(everything) + (noise / scale) ** 2
        factor = cholesky(_covariance(runs.points, extra), lower=True)
        unknown = float(np.median(runs.values))
        prior = _prior_mean(runs.points, runs.simulated, residual, cost_of, unknown)
        white = solve_triangular(factor, (runs.values - prior) / scale, lower=True)
        return cls(runs, cost_of, residual, scale, unknown, factor, white)

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
        mean = _prior_mean(where, twin, self.residual, self.cost_of, self.unknown)
        mean = mean + self.scale * (half.T @ self._white)
        variance = self.scale**2 * np.clip(1.0 - np.sum(half**2, axis=0), 0.0, 1.0)
        return mean, variance


def likeliest_lengthscale(
    points: NDArray[np.float64],
    functions: NDArray[np.float64],
    extra: NDArray[np.float64] | None = None,
) -> float:
    """Lengthscale of functions of time over the gains, by marginal posterior.

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
    """
    median, spread = _LENGTHSCALE_PRIOR
    losses = []
    for lengthscale in LENGTHSCALES:
        loss = 0.5 * (np.log(lengthscale / median) / spread) ** 2
        if len(points):
            covariance = matern52(points, points, lengthscale) + NUGGET * np.eye(len(points))
            if extra is not None:
                covariance += np.diag(extra)
            factor = cholesky(covariance, lower=True)
            white = solve_triangular(factor, functions, lower=True)
            scale = float(np.mean(white**2)) + np.finfo(float).tiny
            loss += 0.5 * len(points) * np.log(scale) + float(np.log(np.diag(factor)).sum())
        losses.append(loss)
    return LENGTHSCALES[int(np.argmin(losses))]


def _corrected(
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    residual: Residual,
) -> NDArray[np.float64]:
    return simulated + residual.mean(points)


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
        mean[known] = cost_of(_corrected(points[known], simulated[known], residual))
    return mean


def _left_out_errors(
    runs: AxisRuns, cost_of: CostOf, lengths: tuple[float, float]
) -> NDArray[np.float64]:
    """Errors of predicting each paired run from the others, in prior standard deviations [g].

    A run close to another one is predicted well by any twin. So each error is divided by the
    posterior standard deviation there, relative to the prior one.
    """
    rows = np.flatnonzero(runs.paired)
    if len(rows) == 0:
        return np.empty(0)
    predicted = []
    for row in rows:
        residual = Residual.fit(runs, rows[rows != row], lengths)
        predicted.append(_corrected(runs.points[[row]], runs.simulated[[row]], residual)[0])
    errors = runs.values[rows] - np.asarray(cost_of(np.array(predicted)), dtype=float)
    extra = runs.extra_of(rows)
    left = 1.0 / np.diag(np.linalg.inv(_covariance(runs.points[rows], extra)))
    return errors / np.sqrt(left)


def _covariance(points: NDArray[np.float64], extra: NDArray[np.float64]) -> NDArray[np.float64]:
    own = matern52(points, points, DEPARTURE_LENGTHSCALE) + NUGGET * np.eye(len(points))
    return np.asarray(own + np.diag(extra))
