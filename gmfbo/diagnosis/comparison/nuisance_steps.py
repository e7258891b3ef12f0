"""Steps of the nuisances alone, beside free quantities that were moved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.numbers import AT_THE_END
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

_POLISHED = 6  # steps at most
LONGEST_STEP = 1.0
"""[1] Of a logarithm, or a filter's coordinate, in one iteration."""


def polished(
    problem: Problem, whitening: Whitening, at: Fitted, cost_of: Callable[[Fitted], float]
) -> Fitted:
    """Let the nuisances follow a fit, which asks for no simulation.

    Parameters
    ----------
    problem : Problem
        Recordings.
    whitening : Whitening
        Under which they are fitted.
    at : Fitted
        With other values of its free quantities.
    cost_of : callable (Fitted) -> float
        [nats]
    """
    one_sided = problem.logging.one_sided
    cost = cost_of(at)
    for _ in range(_POLISHED):
        a, g = np.eye(at.nuisances.size), -at.nuisances
        own = problem.nuisance_columns(at.values, at.nuisances)
        for z, j in zip(whitening(at.residual), whitening(own), strict=True):
            flat = j.reshape(j.shape[0], -1)
            a = a + flat @ flat.T
            g = g + flat @ z.ravel()
        free = ~(at.at_zero & (g < 0.0))
        step = np.zeros(g.size)
        step[free] = np.linalg.solve(a[np.ix_(free, free)], g[free])
        longest = np.where(one_sided, LONGEST_STEP, np.inf)
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
