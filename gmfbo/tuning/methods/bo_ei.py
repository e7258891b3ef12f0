"""Bayesian optimisation of the real axis alone: the baseline that ignores the twin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    improve_axis,
    least_expected,
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
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        return improve_axis(single_source_model(state), state)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean over the box."""
        return least_expected(single_source_model(state), state)
