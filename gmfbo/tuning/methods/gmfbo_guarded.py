"""`gmfbo` that goes on without the twin while the twin misleads."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.method import CorrectionOptions, Method, Proposal
from gmfbo.tuning.methods.beliefs import single_source_model
from gmfbo.tuning.methods.bo_ei import SingleSourceImprovement
from gmfbo.tuning.methods.gmfbo import CORRECTION, Gmfbo, axis_runs, sample_times
from gmfbo.tuning.state import TuningState


@dataclass(frozen=True)
class GuardedGmfbo:
    """`gmfbo` where it predicts left-out real runs no worse than `bo_ei`, otherwise `bo_ei`.

    Attributes
    ----------
    trusting, distrusting : Method
        Who proposes in either case.
    """

    name: str = "gmfbo_guarded"
    summary: str = "gmfbo; bo_ei while the corrected twin predicts left-out real runs worse"
    reference: str = (
        "as gmfbo; left-out runs as in Rasmussen and Williams 2006, section 5.4.2, compared by "
        "the signed-rank test of Wilcoxon 1945"
    )
    correction: CorrectionOptions = CORRECTION
    trusting: Method = field(default_factory=Gmfbo)
    distrusting: Method = field(default_factory=SingleSourceImprovement)

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Let `gmfbo` or `bo_ei` propose."""
        if self._trusts(state):
            return self.trusting.propose(state, rng)
        proposal = self.distrusting.propose(state, rng)
        if proposal is None:
            return None
        note = "the twin predicts left-out real runs worse than real runs alone do: not used"
        return Proposal(proposal.source, proposal.point, proposal.mismatch, note)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """As the one that would propose now."""
        chosen = self.trusting if self._trusts(state) else self.distrusting
        return chosen.recommend(state)

    def _trusts(self, state: TuningState) -> bool:
        from gmfbo.surrogate.guard import TwinGuard
        from gmfbo.surrogate.left_out import errors_alone, errors_with_twin

        guard = TwinGuard()
        real = [trial for trial in state.trials if trial.source == "IS1"]
        if len(real) < guard.least_runs:
            return True
        with_twin = errors_with_twin(*axis_runs(state, sample_times(state)))
        return guard.trusts(with_twin, errors_alone(single_source_model(state)))
