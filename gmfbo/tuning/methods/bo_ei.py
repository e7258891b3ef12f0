"""Bayesian optimisation of the real axis alone: the baseline that ignores the twin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    expected_at,
    expected_incumbent,
    least_expected,
    observations_of,
    search_of,
    seek_finished,
    single_source_model,
)
from gmfbo.tuning.query.method import Proposal


@dataclass(frozen=True)
class SingleSourceImprovement:
    """Expected improvement of a Gaussian process on the real runs."""

    name: str = "bo_ei"
    summary: str = "expected improvement on real runs alone, without the twin"
    reference: str = "Jones, Schonlau and Welch 1998, Efficient global optimization"
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise expected improvement over the box."""
        from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
        from gmfbo.acquisition.maximise import maximise

        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        model, real = single_source_model(state), observations_of(state, "IS1")
        acquisition = CostAwareExpectedImprovement(
            model, {"IS1": expected_incumbent(model, state, real)}, {"IS1": 1.0}
        )
        found = maximise(acquisition, search_of(state), ["IS1"], real)
        expected = expected_at(model, found.point)
        return Proposal("IS1", found.point, note=model.note, expected=expected)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean over the box."""
        return least_expected(single_source_model(state), state)
