"""Profile-likelihood intervals, where parameters trade off along a curve."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.intervals import Spread
from gmfbo.diagnosis.fitting.linear_left_out import normal_equations
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2

Array = NDArray[np.float64]

_WIDE = 0.15  # of a value: narrower intervals hardly bend
_REACHES = (1.0, 1.5, 2.0, 3.0)  # times the half width by the normal theory
_QUANTILE = 3.84  # of a chi-square variable: 95 %
_STEPS = 3  # of the other parameters, at each value of the one


def widened_by_profile(
    misfit: Misfit, fitted: Fitted, spread: Spread, places: Sequence[int]
) -> Spread:
    """Widen the intervals of the parameters at `places` as far as the likelihood allows.

    A shaft of twice the stiffness with 1.4 times the load looks the same below its resonance. The
    derivatives at the fit give the direction of such a valley, but not its bend. So each parameter
    with a wide interval is moved, and the others are refitted (profile likelihood; Venzon,
    Moolgavkar 1988), while chi2 is at most 3.84 above its minimum. The refits are Gauss-Newton
    steps by the derivatives at the fit. Where these fall short, an interval is widened too little,
    and never narrowed.

    Returns
    -------
    Spread
        The same standard deviations with wider intervals.
    """
    low, high = spread.low.copy(), spread.high.copy()
    valley = _Valley(misfit, fitted)
    for i in places:
        for side, end in ((-1.0, low), (1.0, high)):
            half = abs(float(end[i] - fitted.x[i]))
            if half > _WIDE * abs(float(fitted.x[i])):
                end[i] = fitted.x[i] + side * half * valley.reach(i, side * half)
    return Spread(spread.deviation, low, high)


class _Valley:
    """Least chi2 over all other parameters, along one of them."""

    def __init__(self, misfit: Misfit, fitted: Fitted) -> None:
        self._misfit, self._fitted = misfit, fitted
        self._inflation = max(1.0, fitted.chi2 / sum(r.size for r in fitted.residual))
        one_group = [0] * len(fitted.residual)
        normal = normal_equations(fitted.residual, fitted.sensitivity, one_group, fitted.prior)
        self._matrix = normal.matrix[0] + np.diag(fitted.prior)

    def reach(self, i: int, half: float) -> float:
        """Half widths by which the parameter may move, at least 1."""
        x, before, last = self._fitted.x, 0.0, 1.0
        others = np.arange(x.size) != i
        inner = self._matrix[np.ix_(others, others)]
        for times in _REACHES:
            moved = x.copy()
            moved[i] = self._fitted.x[i] + times * half
            change = moved[i] - x[i]
            moved[others] -= np.linalg.solve(inner, self._matrix[others, i]) * change
            moved = self._fitted.hypothesis.inside(moved)
            if abs(moved[i] - x[i]) < 0.5 * abs(change):
                return last  # at its bound
            rise, x = self._least(moved, others, inner)
            if rise > _QUANTILE:
                if times == _REACHES[0]:
                    return 1.0
                share = (np.sqrt(_QUANTILE) - np.sqrt(before)) / (np.sqrt(rise) - np.sqrt(before))
                return float(last + share * (times - last))
            before, last = max(rise, 0.0), times
        return last

    def _least(self, x: Array, others: NDArray[np.bool_], inner: Array) -> tuple[float, Array]:
        best = np.inf, x
        hypothesis = self._fitted.hypothesis
        for _ in range(_STEPS):
            simulated = self._misfit.simulations.run([hypothesis.point(x)])[0]
            if not all(run.finite for run in simulated):
                break
            residual = self._misfit.residual(simulated)
            rise = (chi2(residual) - self._fitted.chi2) / self._inflation
            if rise < best[0]:
                best = rise, x
            slope = sum(
                columns @ block
                for columns, block in zip(self._fitted.sensitivity, residual, strict=True)
            )
            x = x.copy()
            x[others] += np.linalg.solve(inner, np.asarray(slope)[others])
            x = hypothesis.inside(x)
        return best
