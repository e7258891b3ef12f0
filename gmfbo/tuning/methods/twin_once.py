"""What an engineer does without this program: tune on the twin, then go to the axis once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.query.method import CorrectionOptions, Proposal

SURVEY = 400
"""Runs of the twin over the box; a region of one percent of two gains then holds about four."""

SURVEY_ALONE = CorrectionOptions(survey=SURVEY, around_real=False)

SAME = 0.002
"""Distance in the unit cube within which a run counts as made there."""


@dataclass(frozen=True)
class TwinOnce:
    """The best of many runs of the nominal twin, run on the real axis once; then it has done."""

    name: str = "twin_once"
    summary: str = "optimises the nominal twin, then one real run; learns nothing from it"
    reference: str = (
        "the usual practice; its gap: Jakobi, Husbands and Harvey 1995, Noise and the reality gap"
    )
    correction: CorrectionOptions = SURVEY_ALONE

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Ask the axis at the twin's optimum, unless it ran there."""
        best = state.hold(_best_of_twin(state).point)
        if _run_there(state, best) is not None:
            return None
        return Proposal("IS1", best)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Optimum of the twin, with the real cost there where it is known."""
        best = _best_of_twin(state)
        real = _run_there(state, best.point)
        return best.point, (best if real is None else real).objective, 0.0


def _best_of_twin(state: TuningState) -> Observation:
    return min(state.of("IS2"), key=lambda seen: seen.objective)


def _run_there(state: TuningState, point: NDArray[np.float64]) -> Observation | None:
    for seen in state.of("IS1"):
        if np.abs(seen.point - point).max() < SAME:
            return seen
    return None
