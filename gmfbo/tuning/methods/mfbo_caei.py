"""Multi-fidelity Bayesian optimisation by expected improvement for its cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    improve_each_source,
    least_expected,
    observations_of,
    seek_finished,
)
from gmfbo.tuning.query.method import Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.truncated import TruncatedModel

TWIN_COST = 0.1
"""H of a run of the twin, fixed [runs of the axis]."""


@dataclass(frozen=True)
class CostAwareMultiFidelity:
    """BoTorch's multi-fidelity surrogate; EI of each source over its fixed cost."""

    name: str = "mfbo_caei"
    summary: str = "stock multi-fidelity surrogate, EI of each source over its cost (twin 0.1)"
    reference: str = (
        "EI over cost of Snoek, Larochelle and Adams 2012; kernel of Poloczek, Wang and Frazier "
        "2017, Multi-information source optimization"
    )
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise EI / H over gains and source."""
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        data = observations_of(state, "IS1", "IS2")
        return improve_each_source(_fit(state), data, state, TWIN_COST)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box."""
        return least_expected(_fit(state), state)


def _fit(state: TuningState) -> TruncatedModel:
    from gmfbo.surrogate.truncated import TruncatedModel

    return TruncatedModel.fit(observations_of(state, "IS1", "IS2"))
