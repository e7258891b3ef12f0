"""Refit the twin's parameters from other starts where the first fit failed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import qmc

from gmfbo.diagnosis.case.case import chi2_per_dof
from gmfbo.diagnosis.fitting.fit import Fitted, fit_to_the_end
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2
from gmfbo.diagnosis.runs.simulated import Simulated

FAR = 30.0
"""chi2 per degree of freedom above which other starts are tried."""

STARTS = 16
"""Points tried as other starts."""

_SPREAD = 0.3  # of a parameter's size: distance of starts on either side
_FIRST_STEP = 0.05  # of a parameter's size
_STEPS = 60  # points of the search that uses no slopes
_MUCH_LESS = 0.9  # of the chi2 before: an improvement counts only below it


def fitted_from_elsewhere(misfit: Misfit, base: Fitted) -> Fitted:
    """Search points around a fit with large chi2 for a better start.

    A saturated axis switches between both ends of its limit. Derivatives are steep and unreliable
    there, so a fit that uses them may stay at a bad start. The search from the best point uses
    none (Nelder, Mead 1965).
    """
    hypothesis = base.hypothesis
    if chi2_per_dof(base, misfit) <= FAR or not base.x.size:
        return base
    scales = hypothesis.scales

    def square(simulated: list[Simulated]) -> float:
        if not all(run.finite for run in simulated):
            return np.inf
        return chi2(misfit.residual(simulated))

    def square_at(x: NDArray[np.float64]) -> float:
        point = hypothesis.point(hypothesis.inside(x))
        return square(misfit.simulations.run([point])[0])

    sides = 2.0 * qmc.Sobol(base.x.size, scramble=False).random(STARTS) - 1.0
    starts = [hypothesis.inside(base.x + _SPREAD * scales * side) for side in sides]
    points = misfit.simulations.run([hypothesis.point(x) for x in starts])
    squares = [square(simulated) for simulated in points]
    best = int(np.argmin(squares))
    if squares[best] >= base.chi2:
        return base
    corners = starts[best] + _FIRST_STEP * np.vstack([np.zeros_like(scales), np.diag(scales)])
    found = minimize(
        square_at,
        starts[best],
        method="Nelder-Mead",
        options={"initial_simplex": corners, "maxfev": _STEPS},
    )
    parameters = hypothesis.parameters(hypothesis.inside(found.x))
    again = fit_to_the_end(misfit, hypothesis, parameters)
    return again if again is not None and again.chi2 < _MUCH_LESS * base.chi2 else base
