"""Calibrate a twin: estimate its uncertain parameters and tables from real runs.

The estimate is the most probable x under its prior and the recordings, by Gauss-Newton steps in the
form of Levenberg (1944) and Marquardt (1963); the noise of each signal is estimated too. The
Jacobian is found by differences once, and then updated along the steps (Broyden 1965), so that a
later estimate with one more run costs a fraction of the first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.retuning.unknowns import Unknowns

Vector = NDArray[np.float64]

EFFECTIVE_SAMPLES = 75
"""Independent samples by which a run's signal counts, since neighbouring samples are alike."""

FLOOR = 2e-3
"""Least error of a signal over its range, by quantisation and unmodelled physics."""

DIFFERENCE = 0.05
"""Step of the differences in standard deviations of the prior; the encoders of a twin make a
smaller one rough."""

_STEPS, _TRIES, _GAIN = 12, 7, 0.01


@dataclass(frozen=True, eq=False)
class RealRun:
    """One run of the axis to be compared with the twin; s signals, m samples.

    Attributes
    ----------
    number : int
        Of the trial.
    measured : ndarray, shape (s, m)
        [SI]
    simulate : callable
        Maps FMU parameters to the twin's signals, shape (s, m); None where the twin fails.
    weight : float
        Between 0 and 1; less for a run from before the plant changed.
    """

    number: int
    measured: Vector
    simulate: Callable[[dict[str, float]], Vector | None]
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class Estimate:
    """State of an estimation, from which it can be continued.

    Attributes
    ----------
    x : ndarray, shape (size,)
        See `Unknowns`.
    errors : ndarray, shape (s,)
        [SI] RMS error of each signal, at least its floor.
    slopes : dict of int to ndarray, shape (s * m, size)
        Derivative of each run's signals, by number of the trial.
    simulations : int
        Runs of the twin that were made.
    """

    x: Vector
    errors: Vector
    slopes: dict[int, Vector]
    simulations: int = 0

    @classmethod
    def begin(cls, unknowns: Unknowns, signals: int) -> Self:
        """Estimate before any recording: smoothed tables, nominal parameters."""
        return cls(unknowns.smoothed, np.ones(signals), {})


@dataclass(eq=False)
class Calibration:
    """Estimation from some runs.

    Attributes
    ----------
    unknowns : Unknowns
        Estimated parameters and tables.
    runs : sequence of RealRun
        At least one.
    """

    unknowns: Unknowns
    runs: Sequence[RealRun]
    simulations: int = 0

    def estimate(self, start: Estimate) -> Estimate:
        """Continue from an earlier estimate.

        Parameters
        ----------
        start : Estimate
            Earlier estimate, with the slopes of its runs.
        """
        x = start.x
        residuals = self._residuals(x)
        if residuals is None:
            # The twin may not run with its noisy table, but it does with the smooth one.
            x = self.unknowns.smoothed
            residuals = self._residuals(x)
        if residuals is None:
            return replace(start, simulations=self.simulations)
        slopes = {run.number: start.slopes.get(run.number) for run in self.runs}
        fresh = all(slope is None for slope in slopes.values())
        known = {n: s if s is not None else self._slope(n, x) for n, s in slopes.items()}
        damping = 1e-2
        for _ in range(_STEPS):
            scales = self._scales(residuals)
            before = self._loss(x, residuals, scales)
            found = self._step(x, residuals, scales, known, damping, before)
            if found is None:
                if fresh:
                    break
                known = {run.number: self._slope(run.number, x) for run in self.runs}
                fresh, damping = True, 1e-2
                continue
            moved, after, loss, damping = found
            _correct(known, self.runs, moved - x, residuals, after)
            fresh = False
            x, residuals = moved, after
            if before - loss < _GAIN * (1.0 + before):
                break
        return Estimate(x, self.errors(residuals), known, self.simulations)

    def errors(self, residuals: Sequence[Vector]) -> Vector:
        """Weighted RMS error [SI] of each signal over the runs, at least its floor."""
        weights = np.array([run.weight for run in self.runs])
        mean = np.average(_rms(residuals) ** 2, axis=0, weights=weights)
        return np.maximum(np.sqrt(mean), floors(self.runs))

    def _residuals(self, x: Vector) -> list[Vector] | None:
        settings = self.unknowns.settings(x)
        left = []
        for run in self.runs:
            simulated = run.simulate(settings)
            self.simulations += 1
            if simulated is None:
                return None
            left.append(simulated - run.measured)
        return left

    def _slope(self, number: int, x: Vector) -> Vector:
        """Derivative of one run's signals, shape (s * m, size); zero where the twin fails."""
        run = next(run for run in self.runs if run.number == number)
        slope = np.zeros((run.measured.size, x.size))
        at = run.simulate(self.unknowns.settings(x))
        self.simulations += 1 + x.size
        for column in range(x.size if at is not None else 0):
            moved = x.copy()
            moved[column] += DIFFERENCE
            simulated = run.simulate(self.unknowns.settings(moved))
            if simulated is not None:
                assert at is not None
                slope[:, column] = (simulated - at).ravel() / DIFFERENCE
        return slope

    def _scales(self, residuals: Sequence[Vector]) -> list[Vector]:
        """Weight of each sample of each run, shape (s * m,).

        A run that the twin misses by more than the median run counts by its own error: an axis in
        a limit cycle would else decide alone, and no twin follows it.
        """
        scales, each = [], _rms(residuals)
        levels = np.maximum(np.maximum(np.median(each, axis=0), floors(self.runs)), each)
        for run, level in zip(self.runs, levels, strict=True):
            count = run.measured.shape[1]
            share = np.sqrt(run.weight * min(EFFECTIVE_SAMPLES / count, 1.0))
            scales.append(np.repeat(share / level, count))
        return scales

    def _loss(self, x: Vector, residuals: Sequence[Vector], scales: Sequence[Vector]) -> float:
        rows = [left.ravel() * scale for left, scale in zip(residuals, scales, strict=True)]
        return float(sum(row @ row for row in (*rows, self.unknowns.prior_rows(x))))

    def _step(
        self,
        x: Vector,
        residuals: Sequence[Vector],
        scales: Sequence[Vector],
        slopes: dict[int, Vector],
        damping: float,
        before: float,
    ) -> tuple[Vector, list[Vector], float, float] | None:
        """A step that lowers the loss, with its residuals, its loss and the next damping."""
        prior, left = self.unknowns.prior_slope(x), self.unknowns.prior_rows(x)
        normal, gradient = prior.T @ prior, prior.T @ left
        for run, residual, scale in zip(self.runs, residuals, scales, strict=True):
            weighted = slopes[run.number] * scale[:, None]
            normal = normal + weighted.T @ weighted
            gradient = gradient + weighted.T @ (residual.ravel() * scale)
        bounds = self.unknowns.bounds
        for _ in range(_TRIES):
            moved = _bounded_step(normal + damping * np.eye(x.size), gradient, x, bounds)
            after = self._residuals(moved)
            if after is not None and (loss := self._loss(moved, after, scales)) < before:
                return moved, after, loss, max(damping / 5.0, 1e-4)
            damping *= 8.0
        return None


def _bounded_step(
    normal: Vector, gradient: Vector, x: Vector, bounds: tuple[Vector, Vector]
) -> Vector:
    """Least of a quadratic loss about x; what would leave its bounds is held there.

    Friction and delays begin at their least value. Cut off after an unbounded step, a lag that
    should be negative would leave a delay that is too long.
    """
    moved, free = np.array(x), np.ones(x.size, dtype=bool)
    while free.any():
        held = normal[np.ix_(free, ~free)] @ (moved - x)[~free]
        step = -np.linalg.solve(normal[np.ix_(free, free)], gradient[free] + held)
        moved[free] = x[free] + step
        beyond = free & ((moved < bounds[0]) | (moved > bounds[1]))
        if not beyond.any():
            break
        moved = np.clip(moved, *bounds)
        free &= ~beyond
    return moved


def _rms(residuals: Sequence[Vector]) -> Vector:
    return np.array([np.sqrt(np.mean(left**2, axis=1)) for left in residuals])


def floors(runs: Sequence[RealRun]) -> Vector:
    """Least error [SI] of each signal, shape (s,)."""
    ranges = np.max([np.ptp(run.measured, axis=1) for run in runs], axis=0)
    return FLOOR * np.where(ranges > 0.0, ranges, 1.0)


def _correct(
    slopes: dict[int, Vector],
    runs: Sequence[RealRun],
    step: Vector,
    before: Sequence[Vector],
    after: Sequence[Vector],
) -> None:
    """Update the slopes by the step just made (Broyden 1965, eq. 4.5)."""
    length = float(step @ step)
    for run, old, new in zip(runs, before, after, strict=True):
        slope = slopes[run.number]
        missed = (new - old).ravel() - slope @ step
        slopes[run.number] = slope + np.outer(missed, step) / length
