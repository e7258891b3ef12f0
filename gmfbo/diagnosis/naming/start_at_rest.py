"""Whether what pushes an axis at rest did so before the recordings, or begins with them.

A recording of a real axis begins where axis and controller have come to rest under all that acts,
known or not. A simulated one may begin with the twin's own start, and a force then sets the axis
in motion. Which of the two these recordings are is not written in them, but the forces that
explain them tell: taken the other way, they leave a start-up that never was.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.case.case import Case, chi2_per_dof
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.misfit import chi2
from gmfbo.diagnosis.naming.threshold import LEAST_THRESHOLD
from gmfbo.diagnosis.screening.probes import probes, screen


def screen_both_starts(
    case: Case, model: Fitted, library: Sequence[Candidate], groups: Sequence[int]
) -> None:
    """Let the recordings begin in the way in which forces at rest explain more of them."""
    simulations = case.simulations
    pushing = [candidate for candidate in library if candidate.law.acts_at_rest]
    if not simulations.rest or not pushing:
        return

    def gain() -> float:
        screened = screen(case.misfit, model, probes(case.misfit, model, pushing), groups)
        return screened[0].gain if screened else -np.inf

    at_rest = gain()
    simulations.begins_at_rest = False
    simulations.begins_at_rest = not gain() > at_rest + _margin(case, model)


def begun_better(case: Case, model: Fitted, fits: list[Fitted]) -> tuple[Fitted, list[Fitted]]:
    """Fit again where the other way to begin leaves clearly less.

    Parameters
    ----------
    case : Case
        Its simulations are changed.
    model : Fitted
        To which the fits have added an effect each.
    fits : list of Fitted
        The best of those that push at rest decides.

    Returns
    -------
    model, fits : Fitted, list of Fitted
        The same, or fitted again.
    """
    simulations = case.simulations
    pushing = [fitted for fitted in fits if fitted.hypothesis.acts_at_rest]
    if not simulations.rest or not pushing:
        return model, fits
    best = min(pushing, key=lambda fitted: fitted.chi2)
    simulations.begins_at_rest = not simulations.begins_at_rest
    runs = simulations.run([fitted.hypothesis.point(fitted.x) for fitted in pushing])
    finite = [run for run in runs if all(one.finite for one in run)]
    least = min((chi2(case.misfit.residual(run)) for run in finite), default=np.inf)
    if least >= best.chi2 - _margin(case, best):
        simulations.begins_at_rest = not simulations.begins_at_rest
        return model, fits
    return _again(case, model), [_again(case, fitted) for fitted in fits]


def _again(case: Case, fitted: Fitted) -> Fitted:
    if not fitted.hypothesis.acts_at_rest:
        return fitted
    again = fit(case.misfit, fitted.hypothesis, fitted.parameters, near=fitted, parallel=True)
    return fitted if again is None else again


def _margin(case: Case, fitted: Fitted) -> float:
    """What a model that leaves more than noise may gain by chance is larger."""
    return LEAST_THRESHOLD * max(1.0, chi2_per_dof(fitted, case.misfit))
