"""Random search: the baseline that knows nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.method import Proposal
from gmfbo.tuning.methods.beliefs import least_expected, single_source_model
from gmfbo.tuning.state import TuningState


@dataclass(frozen=True)
class RandomSearch:
    """Real runs at uniformly random gains."""

    name: str = "random"
    summary: str = "real runs at uniformly random gains"
    reference: str = "Bergstra and Bengio 2012, Random search for hyper-parameter optimization"
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Draw a point of the box."""
        return Proposal("IS1", state.hold(rng.random(len(state.space))))

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Best point of the box by a Gaussian process on the real runs."""
        return least_expected(single_source_model(state), state)
