"""Whether what was fitted is the same in each stretch of the recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import (
    normal_equations,
    solve_weakly_bound,
    sums_of_others,
)
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.fitting.simulated_left_out import simulated_left_out, squares

_BY_CHANCE = 10.0  # times what noise makes of it: far more than chance does


def inconstant(misfit: Misfit, fitted: Fitted, groups: Sequence[int]) -> float:
    """What a fit to the other groups misses in each, where that is no chance; 0 otherwise.

    A law that is the right one has the same parameters everywhere: fitted without a stretch it
    foretells that stretch but for noise. One that is bent to all of them does not (Chow 1960). How
    much noise makes of it follows from the sensitivities, so that a parameter that only one stretch
    shows speaks for nothing. Sensitivities of an axis that sticks may lead astray, so what they say
    is simulated.

    Parameters
    ----------
    misfit : Misfit
        Recordings, simulators and a budget.
    fitted : Fitted
        The twin with all named effects, measured by the same.
    groups : sequence of int
        Group of each window.

    Returns
    -------
    float
        Rise of chi2 over all groups when each is foretold from the others.
    """
    normal = normal_equations(fitted.residual, fitted.sensitivity, groups, fitted.prior)
    if len(normal.square) < 2 or not fitted.x.size:
        return 0.0
    rise = float(np.sum(normal.left_out() - normal.square))
    whole, others = normal.matrix.sum(axis=0), sums_of_others(normal.matrix)
    by_noise = sum(
        float(np.trace(solve_weakly_bound(matrix, own, normal.precision)))
        for own, rest in zip(normal.matrix, others, strict=True)
        for matrix in (rest, whole)
    )
    dispersion = max(1.0, fitted.chi2 / sum(block.size for block in fitted.residual))
    least = _BY_CHANCE * dispersion * by_noise
    if rise <= least:
        return 0.0
    simulated = simulated_left_out(misfit, fitted, groups) - squares(fitted.residual, groups)
    rise = min(rise, float(simulated.sum()))
    return rise if rise > least else 0.0
