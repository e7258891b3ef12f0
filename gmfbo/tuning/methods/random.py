"""Random search: the baseline that knows nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import least_expected, single_source_model
from gmfbo.tuning.query.method import Proposal

MOST_DRAWS = 256
"""Draws among which one that is not beside unsafe gains is sought."""


@dataclass(frozen=True)
class RandomSearch:
    """Real runs at uniformly random gains."""

    name: str = "random"
    summary: str = "real runs at uniformly random gains"
    reference: str = "Bergstra and Bengio 2012, Random search for hyper-parameter optimization"
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Draw a point of the box."""
        drawn = state.hold(rng.random((MOST_DRAWS, len(state.space))))
        allowed = state.keep_out.admitted(drawn)
        return Proposal("IS1", drawn[int(np.argmax(allowed))])

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Best point of the box by a Gaussian process on the real runs."""
        return least_expected(single_source_model(state), state)
