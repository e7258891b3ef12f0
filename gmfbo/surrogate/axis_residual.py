"""What the axis does that its twin does not, over the gains, and what another run may do.

residual = Residual.fit(runs, rows, Residual.smoothness(runs, rows))
residual.mean(points)                                      # (q, m) [signal]
residual.expected_cost(points, simulated, cost_of)         # (q,) [g]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.residual_process import NUGGET, ResidualProcess
from gmfbo.errors import InputError
from gmfbo.surrogate.smoothness import Smoothness, likeliest_smoothness

CostOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]

# Newest runs whose own departures, and their mirror images, are what another run may do: later
# ones lie near the best gains, and friction acts as it does there.
OWN_RUNS = 4
# Rows whose cost is computed at once.
_MOST_ROWS = 2048


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
    departures : ndarray, shape (r, m - beside)
        [signal] What another run at the same gains may do differently, or the process cannot
        follow; a single row of zeros while runs are too few to tell, or repeat themselves.
    """

    of_samples: ResidualProcess
    of_numbers: ResidualProcess | None
    departures: NDArray[np.float64]

    @staticmethod
    def smoothness(runs: AxisRuns, rows: NDArray[np.intp]) -> tuple[Smoothness, Smoothness]:
        """Likeliest smoothness of the samples and of the numbers.

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
            likeliest_smoothness(points, samples, extra),
            likeliest_smoothness(points, scaled, extra) if runs.beside else Smoothness(1.0, NUGGET),
        )

    @classmethod
    def fit(
        cls, runs: AxisRuns, rows: NDArray[np.intp], smoothness: tuple[Smoothness, Smoothness]
    ) -> Self:
        """Condition on some of the runs.

        Parameters
        ----------
        runs : AxisRuns
            Runs of the axis.
        rows : ndarray of int, shape (k,)
            Which of them count; they have both trajectories.
        smoothness : tuple of Smoothness
            Of the samples and of the numbers.
        """
        points, extra = runs.points[rows], runs.extra_of(rows)
        fitted = [
            ResidualProcess.fit(
                points, part, lengthscale=one.lengthscale, extra=extra + (one.repeated - NUGGET)
            )
            for part, one in zip(_parts(runs, rows), smoothness, strict=True)
        ]
        repeated = smoothness[0].repeated if smoothness[0].repeated > NUGGET else 0.0
        departures = (
            fitted[0].departures(repeated, OWN_RUNS)
            if repeated
            else np.zeros((1, runs.measured.shape[1] - runs.beside))
        )
        return cls(fitted[0], fitted[1] if runs.beside else None, departures)

    def mean(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Posterior mean, shape (q, m), at points of the unit cube, shape (q, d)."""
        found = self.of_samples.mean(points)
        if self.of_numbers is None:
            return found
        return np.hstack([found, self.of_numbers.mean(points)])

    def repeats(
        self, points: NDArray[np.float64], simulated: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """What repeated runs may be [signal], shape (q, r, m): corrected, and with each departure.

        Parameters
        ----------
        points : ndarray, shape (q, d)
            Gains in the unit cube.
        simulated : ndarray, shape (q, m)
            [signal] The twin there.
        """
        corrected = simulated + self.mean(points)
        runs = np.repeat(corrected[:, None, :], len(self.departures), axis=1)
        runs[:, :, : self.departures.shape[1]] += self.departures
        return runs

    def expected_cost(
        self, points: NDArray[np.float64], simulated: NDArray[np.float64], cost_of: CostOf
    ) -> NDArray[np.float64]:
        """Cost g of a run that is corrected, the mean over what a repeated run does, shape (q,).

        The cost of the mean trajectory is another thing: where one run in two leaves the settling
        band, the mean trajectory is on one side of it.

        Parameters
        ----------
        points : ndarray, shape (q, d)
            Gains in the unit cube.
        simulated : ndarray, shape (q, m)
            [signal] The twin there.
        cost_of : callable
            From trajectories, shape (q, m), to g, shape (q,).
        """
        block = max(_MOST_ROWS // len(self.departures), 1)
        parts = [
            mean_cost(self.repeats(points[at : at + block], simulated[at : at + block]), cost_of)
            for at in range(0, len(points), block)
        ]
        return np.concatenate(parts) if parts else np.empty(0)


def mean_cost(runs: NDArray[np.float64], cost_of: CostOf) -> NDArray[np.float64]:
    """Mean cost g over repeated runs, shape (q,), of runs of shape (q, r, m)."""
    count, repeats, columns = runs.shape
    costs = np.asarray(cost_of(runs.reshape(-1, columns)), dtype=float)
    return np.asarray(costs.reshape(count, repeats).mean(axis=1))


def _parts(
    runs: AxisRuns, rows: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals of some runs: samples (k, m - beside), and numbers (k, beside)."""
    left = (runs.measured - runs.simulated)[rows]
    samples = left.shape[1] - runs.beside
    return left[:, :samples], left[:, samples:]
