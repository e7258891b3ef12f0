"""Leave-one-group-out misfit by simulation, where a linear fit is not reliable.

A gap or a limit makes the misfit rough, and a linear step from the fit on all recordings may go
astray. Each step is simulated, and taken only if it lowers the chi2 of the fitted groups.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import (
    normal_equations,
    solve_weakly_bound,
    sums_of_others,
)
from gmfbo.diagnosis.fitting.misfit import Blocks, Misfit


def simulated_left_out(
    misfit: Misfit, fitted: Fitted, groups: Sequence[int], held: int = 0
) -> NDArray[np.float64]:
    """chi2 of each group by parameters fitted to all others, simulated; shape (n_groups,).

    Parameters
    ----------
    misfit : Misfit
        Recordings and simulators.
    fitted : Fitted
        On all groups.
    groups : sequence of int
        Group of each window.
    held : int
        Number of last parameters that keep their values from all groups.
    """
    free = range(fitted.x.size - held)
    normal = normal_equations(fitted.residual, fitted.sensitivity, groups, fitted.prior).only(free)
    matrix, vector = sums_of_others(normal.matrix), sums_of_others(normal.vector)
    hypothesis, moved = fitted.hypothesis, []
    for m, v in zip(matrix, vector, strict=True):
        step = solve_weakly_bound(m, v[:, None], normal.precision)[:, 0]
        moved.append(hypothesis.inside(fitted.x + np.concatenate([step, np.zeros(held)])))
    runs = misfit.simulations.run([hypothesis.point(x) for x in moved])
    here = squares(fitted.residual, groups)
    left_out = here.copy()
    for g, simulated in enumerate(runs):
        if not all(run.finite for run in simulated):
            continue
        # The signals of a diverging run may be finite while their square is not: reject it.
        with np.errstate(over="ignore", invalid="ignore"):
            there = squares(misfit.residual(simulated), groups)
            serves = there.sum() - there[g] < here.sum() - here[g]
        if serves:
            left_out[g] = there[g]
    return left_out


def squares(residual: Blocks, groups: Sequence[int]) -> NDArray[np.float64]:
    """chi2 of each group of whitened windows, shape (n_groups,)."""
    total = np.zeros(max(groups) + 1)
    for block, g in zip(residual, groups, strict=True):
        total[g] += float(block @ block)
    return total
