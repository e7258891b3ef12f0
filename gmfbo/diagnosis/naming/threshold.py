"""How large a gain chance alone gives, over the whole library, for this twin and recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.linear_left_out import (
    normal_equations,
    solve_weakly_bound,
    sums_of_others,
)
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit
from gmfbo.diagnosis.screening.probes import Probe

LEAST_THRESHOLD = 30.0
"""Of a gain. Noise alone gives 15; a lag, a clock or a scale that is off gave up to 38."""

_DRAWS = 200
_QUANTILE = 0.99


class NullGains:
    """The largest left-out gain over all probes, for residuals without any effect.

    Everything but the residual is fixed, so that a draw costs no simulation.

    Parameters
    ----------
    misfit : Misfit
        Recordings and budget.
    base : Fitted
        The twin with its parameters refitted.
    tried : sequence of Probe
        The whole library and its grids.
    groups : sequence of int
        Group of each window; whole groups are left out together.
    """

    def __init__(
        self, misfit: Misfit, base: Fitted, tried: Sequence[Probe], groups: Sequence[int]
    ) -> None:
        self._groups = list(groups)
        self._own = base.sensitivity
        self._prior = base.prior
        self._probes = [(stacked(misfit, p.columns), p.prior) for p in tried]
        self._sizes = [w.n_residuals for w in misfit.whiteners]

    def threshold(self, rng: np.random.Generator) -> float:
        """Gain that chance exceeds once in a hundred times, at least LEAST_THRESHOLD."""
        if not self._probes:
            return LEAST_THRESHOLD
        draws = tuple(rng.standard_normal((size, _DRAWS)) for size in self._sizes)
        return max(LEAST_THRESHOLD, float(np.quantile(self.largest(draws), _QUANTILE)))

    def largest(self, residuals: Blocks) -> NDArray[np.float64]:
        """Largest gain over the probes for each of several residuals, shape (n_draws,)."""
        left_out, fitted = self._squares(self._own, residuals, self._prior)
        most = np.full(fitted.size, -np.inf)
        for columns, prior in self._probes:
            together = tuple(
                np.concatenate([own, more]) for own, more in zip(self._own, columns, strict=True)
            )
            both = np.concatenate([self._prior, prior])
            after = self._squares(together, residuals, both)
            most = np.maximum(most, np.minimum(left_out - after[0], fitted - after[1]))
        return most

    def _squares(
        self, columns: Blocks, residuals: Blocks, prior: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What remains in each group after a fit on all others, and after a fit on all; summed."""
        count, n, draws = max(self._groups) + 1, len(columns[0]), residuals[0].shape[1]
        matrix = np.zeros((count, n, n))
        vector = np.zeros((count, n, draws))
        for a, r, g in zip(columns, residuals, self._groups, strict=True):
            matrix[g] += a @ a.T
            vector[g] += a @ r
        whole, right = matrix.sum(axis=0), vector.sum(axis=0)
        change = solve_weakly_bound(whole, right, prior)
        fitted = _remaining(whole, right, change)
        if count == 1:
            return fitted, fitted
        left_out = np.zeros(draws)
        for g, (m, v) in enumerate(
            zip(sums_of_others(matrix), sums_of_others(vector), strict=True)
        ):
            left_out += _remaining(matrix[g], vector[g], solve_weakly_bound(m, v, prior))
        return left_out, fitted


def _remaining(
    matrix: NDArray[np.float64], vector: NDArray[np.float64], change: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Change of the square by a change of the parameters, of each draw."""
    linear: NDArray[np.float64] = np.einsum("ij,ij->j", change, vector)
    quadratic: NDArray[np.float64] = np.einsum("ij,ik,kj->j", change, matrix, change)
    return quadratic - 2.0 * linear


def left_out_square(fitted: Fitted, groups: Sequence[int]) -> NDArray[np.float64]:
    """Square that a fit leaves in each group which it does not see, shape (n_groups,).

    Linear about the fit on all groups: no group is simulated again.
    """
    normal = normal_equations(fitted.residual, fitted.sensitivity, groups, fitted.prior)
    return normal.left_out()
