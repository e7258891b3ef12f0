"""Effects joined to a fitted model as trials, before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.fitting.linear_left_out import square_after_refit
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.runs.simulated import Simulated


def with_effect(base: Hypothesis, candidate: Candidate) -> Hypothesis:
    """One effect more."""
    return replace(base, effects=(*base.effects, candidate))


@dataclass(frozen=True, eq=False)
class Trial:
    """A candidate simulated at its start, and what a linear refit would leave.

    Attributes
    ----------
    hypothesis : Hypothesis
        The model with the candidate.
    parameters : dict of str to float
        Of the twin.
    square : float
        chi2 after one linear step of the twin's parameters.
    simulated : list of Simulated
        The recordings there.
    """

    hypothesis: Hypothesis
    parameters: dict[str, float]
    square: float
    simulated: list[Simulated]

    @property
    def candidate(self) -> Candidate:
        """The candidate at its start."""
        return self.hypothesis.effects[-1]


def trials_of(misfit: Misfit, base: Fitted, candidate: Candidate) -> list[Trial]:
    """Simulate a candidate at its start, under the refitted and under the nominal parameters.

    The refitted parameters of a twin without the effect have swallowed part of it: the nominal
    ones may be nearer to the truth.
    """
    setting = base.hypothesis.setting
    hypothesis = with_effect(base.hypothesis, candidate)
    nominal = {u.name: u.nominal for u in setting.uncertain}
    trials = []
    for parameters in (base.parameters, nominal):
        simulated = misfit.simulations.run_here(hypothesis.point(hypothesis.start(parameters)))
        if all(run.finite for run in simulated):
            square = square_after_refit(misfit.residual(simulated), base.sensitivity, base.prior)
            trials.append(Trial(hypothesis, parameters, square, simulated))
    return trials


def least_square(misfit: Misfit, base: Fitted, candidate: Candidate) -> float:
    """chi2 of the better trial of a candidate; infinite where none can be simulated."""
    return min((t.square for t in trials_of(misfit, base, candidate)), default=np.inf)
