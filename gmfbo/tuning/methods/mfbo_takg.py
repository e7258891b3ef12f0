"""Multi-fidelity Bayesian optimisation by the knowledge gradient."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    least_expected,
    observations_of,
    search_of,
    seek_finished,
    source_of,
)
from gmfbo.tuning.query.method import Proposal


@dataclass(frozen=True)
class MultiFidelityKnowledgeGradient:
    """BoTorch's multi-fidelity surrogate and the knowledge gradient, cost 0.1 + 0.9 s."""

    name: str = "mfbo_takg"
    summary: str = "stock multi-fidelity surrogate, knowledge gradient over cost 0.1 + 0.9 s"
    reference: str = (
        "Wu, Toscano-Palmerin, Frazier and Wilson 2019, Practical multi-fidelity Bayesian "
        "optimization; closed form of Frazier, Powell and Dayanik 2009"
    )
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise the knowledge gradient for its cost over gains and source."""
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        from gmfbo.acquisition.knowledge_gradient import KnowledgeGradient
        from gmfbo.acquisition.maximise import maximise
        from gmfbo.surrogate.truncated import TruncatedModel

        data, search = observations_of(state, "IS1", "IS2"), search_of(state)
        acquisition = KnowledgeGradient(TruncatedModel.fit(data), search)
        found = maximise(acquisition, search, ("IS1", "IS2"), data)
        return Proposal(source_of(found), found.point)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box."""
        from gmfbo.surrogate.truncated import TruncatedModel

        return least_expected(TruncatedModel.fit(observations_of(state, "IS1", "IS2")), state)
