"""Guided multi-fidelity Bayesian optimisation as its publication prints it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    corrected_and_twin,
    incumbent_of,
    least_expected,
    search_of,
    source_of,
    unprompted_observations,
)
from gmfbo.tuning.query.method import CorrectionOptions, Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.model import SourceModel
    from gmfbo.surrogate.observations import Observations

AS_PRINTED = CorrectionOptions(memory="latest", at_border="project")


@dataclass(frozen=True)
class PrintedGmfbo:
    """Algorithm 1 as printed: corrected runs count as runs of the twin, l_g0 is at most 1."""

    name: str = "gmfbo_paper"
    summary: str = "corrected twin runs as twin data, mismatch on g, l_g0 = 1/e within [0.1, 1]"
    reference: str = (
        "Nobar et al. 2025, Guided multi-fidelity Bayesian optimization, arXiv:2509.17952"
    )
    correction: CorrectionOptions = AS_PRINTED
    prices_failures: bool = True

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise EI / H over gains and source, each with the incumbent of its source."""
        from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
        from gmfbo.acquisition.maximise import maximise
        from gmfbo.objective.mismatch import query_cost

        data, mismatch = _data(state), printed_mismatch(state)
        model = fit_surrogate(data, mismatch)
        acquisition = CostAwareExpectedImprovement(
            model,
            {
                "IS1": incumbent_of(state, data, "IS1"),
                "IS2": incumbent_of(state, data, "IS2", "IS3"),
            },
            {"IS1": 1.0, "IS2": query_cost(mismatch)},
            value="source",
        )
        found = maximise(acquisition, search_of(state), ["IS1", "IS2"], data)
        return Proposal(source_of(found), found.point, mismatch, model.note)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box."""
        return least_expected(fit_surrogate(_data(state), printed_mismatch(state)), state)


def _data(state: TuningState) -> Observations:
    return unprompted_observations(state, "IS1", "IS2", "IS3")


def printed_mismatch(state: TuningState) -> float:
    """Mean of |g_c - g_2| / |g_c| over the corrected runs; 1 without any."""
    from gmfbo.objective.mismatch import relative_mismatch

    return relative_mismatch(*corrected_and_twin(state, scaled=False))


def fit_surrogate(data: Observations, mismatch: float) -> SourceModel:
    """Fit the printed surrogate, with l_g0 set by the mismatch."""
    from gmfbo.objective.mismatch import source_lengthscale
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings

    settings = SurrogateSettings(source_lengthscale=source_lengthscale(mismatch))
    return SourceModel.fit(data, settings)
