"""`gmfbo` with fewer runs of the twin, and gains between them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.method import CorrectionOptions, Proposal
from gmfbo.tuning.methods.beliefs import corrected_and_twin, search_of
from gmfbo.tuning.methods.gmfbo import CORRECTION, corrected_model, sample_times, twin_runs
from gmfbo.tuning.state import TuningState

if TYPE_CHECKING:
    from gmfbo.correction.residual_process import ResidualProcess
    from gmfbo.surrogate.corrected_twin import CorrectedTwinModel

SURVEY = 150
"""Runs of the twin over the box, between which its trajectories are interpolated."""

SMALL_SURVEY = replace(CORRECTION, survey=SURVEY)


@dataclass(frozen=True)
class EmulatedGmfbo:
    """The corrected twin of `gmfbo`, searched on an emulator of the twin."""

    name: str = "gmfbo_emulated"
    summary: str = "gmfbo with 150 runs of the twin instead of 400, interpolated between them"
    reference: str = (
        "as gmfbo; emulator of Conti and O'Hagan 2010, Bayesian emulation of complex multi-output "
        "and dynamic computer models"
    )
    correction: CorrectionOptions = SMALL_SURVEY

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Ask the real axis where the corrected twin promises most."""
        from gmfbo.acquisition.emulated_twin import next_axis_run
        from gmfbo.objective.mismatch import scaled_mismatch

        mismatch = scaled_mismatch(*corrected_and_twin(state, scaled=True))
        fitted = _fit(state)
        if fitted is None:
            blind = state.hold(rng.random(len(state.space)))
            return Proposal("IS1", blind, mismatch, "the twin has not succeeded anywhere")
        point, _ = next_axis_run(*fitted, search_of(state), rng, state.incumbent())
        return Proposal("IS1", point, mismatch)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least expected cost over the box; the search draws from a fixed stream."""
        from gmfbo.acquisition.emulated_twin import expected_best

        fitted = _fit(state)
        if fitted is None:
            best = min(state.of("IS1"), key=lambda seen: seen.objective)
            return best.point, best.objective, 0.0
        model, emulator = fitted
        point, mean = expected_best(model, emulator, search_of(state), np.random.default_rng(0))
        _, variance = model.predict(point[None, :], emulator.mean(point[None, :]))
        return point, mean, float(np.sqrt(variance[0]))


def _fit(state: TuningState) -> tuple[CorrectedTwinModel, ResidualProcess] | None:
    from gmfbo.acquisition.emulated_twin import emulate

    times = sample_times(state)
    points, simulated = twin_runs(state, times)
    if not len(points):
        return None
    return corrected_model(state, times), emulate(points, simulated)
