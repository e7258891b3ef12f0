"""Steps of the nuisances alone, beside free quantities that were moved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.numbers import AT_THE_END
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_POLISHED = 6  # steps at most
LONGEST_STEP = 1.0
"""[1] Of a logarithm, or a filter's coordinate, in one iteration."""


class WhiteResiduals:
    """Whitened residuals; the last one is kept, since a cost and then its slope ask for it.

    Parameters
    ----------
    whitening : Whitening
        By noise.
    """

    def __init__(self, whitening: Whitening) -> None:
        self._whitening = whitening
        self._last: tuple[Sequence[Array], list[Array]] = ((), [])

    def of(self, at: Fitted) -> list[Array]:
        """Of a fit, by segment, shape (m, n)."""
        if at.residual is not self._last[0]:
            self._last = at.residual, self._whitening(at.residual)
        return self._last[1]

    def square(self, at: Fitted) -> float:
        """Sum of their squares."""
        return sum(float(np.sum(z**2)) for z in self.of(at))


def polished(
    problem: Problem,
    whites: WhiteResiduals,
    columns: Sequence[Array],
    at: Fitted,
    cost_of: Callable[[Fitted], float],
) -> Fitted:
    """Let the nuisances follow a fit, which asks for no simulation.

    Parameters
    ----------
    problem : Problem
        Recordings.
    whites : WhiteResiduals
        Under which they are fitted.
    columns : sequence of ndarray, shape (q, m, n)
        Whitened change of each segment per standard deviation of each nuisance. Those of the point
        before will do: a step that raises the cost is not taken.
    at : Fitted
        With other values of its free quantities.
    cost_of : callable (Fitted) -> float
        [nats]
    """
    one_sided = problem.logging.one_sided
    longest = np.where(one_sided, LONGEST_STEP, np.inf)
    flat = [j.reshape(j.shape[0], -1) for j in columns]
    a = np.eye(at.nuisances.size) + sum(j @ j.T for j in flat)
    cost = cost_of(at)
    for _ in range(_POLISHED):
        g = sum(j @ z.ravel() for j, z in zip(flat, whites.of(at), strict=True)) - at.nuisances
        free = ~(at.at_zero & (g < 0.0))
        step = np.zeros(g.size)
        step[free] = np.linalg.solve(a[np.ix_(free, free)], g[free])
        nuisances = at.nuisances + np.clip(step, -longest, longest)
        nuisances[one_sided] = np.maximum(nuisances[one_sided], 0.0)
        residual = problem.residual(at.values, nuisances)
        tried = replace(at, nuisances=nuisances, residual=residual)
        after = cost_of(tried)
        if after >= cost:
            break
        gained, at, cost = cost - after, tried, after
        if gained < AT_THE_END:
            break
    return at
