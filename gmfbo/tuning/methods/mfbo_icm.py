"""Multi-fidelity Bayesian optimisation that learns how much the sources have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import improve_each_source, least_expected, observations_of
from gmfbo.tuning.methods.mfbo_caei import TWIN_COST
from gmfbo.tuning.query.method import Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.coregionalised import CoregionalisedModel


@dataclass(frozen=True)
class CoregionalisedMultiFidelity:
    """As `mfbo_caei`, but the correlation of axis and twin is learned instead of fixed."""

    name: str = "mfbo_icm"
    summary: str = "learned correlation of axis and twin, EI of each source over its cost"
    reference: str = (
        "Swersky, Snoek and Adams 2013, Multi-task Bayesian optimization; model of Bonilla, Chai "
        "and Williams 2008"
    )
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise EI / H over gains and source."""
        data = observations_of(state, "IS1", "IS2")
        return improve_each_source(_fit(state), data, state, TWIN_COST)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box."""
        return least_expected(_fit(state), state)


def _fit(state: TuningState) -> CoregionalisedModel:
    from gmfbo.surrogate.coregionalised import CoregionalisedModel

    return CoregionalisedModel.fit_sources(observations_of(state, "IS1", "IS2"))
