"""The printed method without its corrected runs in the surrogate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import (
    improve_each_source,
    least_expected,
    unprompted_observations,
)
from gmfbo.tuning.methods.gmfbo_paper import AS_PRINTED, fit_surrogate, printed_mismatch
from gmfbo.tuning.query.method import CorrectionOptions, Proposal


@dataclass(frozen=True)
class AdaptiveMultiFidelity:
    """Kernel and cost adapt to the mismatch; corrected runs (IS3) serve that number alone."""

    name: str = "mfbo_adaptive"
    summary: str = "gmfbo_paper whose corrected runs only measure the mismatch"
    reference: str = "after Nobar et al. 2025, arXiv:2509.17952: its kernel and cost alone"
    correction: CorrectionOptions = AS_PRINTED

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise EI / H over gains and source, with l_g0 and H from the mismatch."""
        from gmfbo.objective.mismatch import query_cost

        data, mismatch = unprompted_observations(state, "IS1", "IS2"), printed_mismatch(state)
        model = fit_surrogate(data, mismatch)
        return improve_each_source(model, data, state, query_cost(mismatch), mismatch)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box."""
        data = unprompted_observations(state, "IS1", "IS2")
        return least_expected(fit_surrogate(data, printed_mismatch(state)), state)
