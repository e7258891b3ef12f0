"""What the corrected twin is worth: as a source of its own, or not at all, in place of a prior."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.retuning.corrected_methods import GMFBO_ESTIMATED, OnCorrectedTwin
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods import gmfbo
from gmfbo.tuning.methods.beliefs import (
    improve_axis,
    least_expected,
    observations_of,
    seek_finished,
)
from gmfbo.tuning.methods.gmfbo import Gmfbo
from gmfbo.tuning.query.method import CorrectionOptions, Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.axis_residual import AxisRuns, CostOf
    from gmfbo.surrogate.model import SourceModel

Vector = NDArray[np.float64]

SURVEY = 100
"""Runs of the twin over the box that the surrogate of three sources learns from."""

AROUND = CorrectionOptions(memory="latest", at_border="reflect", survey=SURVEY)


@dataclass(frozen=True)
class ThreeSources:
    """Expected improvement of a Gaussian process over gains and three sources.

    The axis, the twin, and the twin's runs around each real run corrected by it (IS3) are one
    surrogate, whose correlation between sources is learned. The axis alone is asked.
    """

    name: str = "three_sources"
    summary: str = "corrected runs as a third source of the surrogate"
    reference: str = "Poloczek, Wang and Frazier 2017, Multi-information source optimization"
    correction: CorrectionOptions = AROUND

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise expected improvement of the axis over the box."""
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        return improve_axis(_three_sources(state), state)

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """Least posterior mean among the runs that settled."""
        return least_expected(_three_sources(state), state)


def _three_sources(state: TuningState) -> SourceModel:
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings

    settings = SurrogateSettings(
        source_lengthscale=None, ard=True, third_source=True, noise_per_source=True
    )
    return SourceModel.fit(observations_of(state, "IS1", "IS2", "IS3"), settings)


@dataclass(frozen=True)
class UncorrectedGmfbo(Gmfbo):
    """`gmfbo` whose prior mean is the cost of the twin itself, without a correction of its runs."""

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """As `gmfbo`."""
        with _uncorrected():
            return super().propose(state, rng)

    def promising(self, state: TuningState) -> Vector:
        """As `gmfbo`."""
        with _uncorrected():
            return super().promising(state)

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """As `gmfbo`."""
        with _uncorrected():
            return super().recommend(state)


@contextmanager
def _uncorrected() -> Iterator[None]:
    """Within it real runs say nothing of trajectories: they count as what the twin did there."""
    place: Any = gmfbo
    as_it_is = place.axis_runs

    def without(state: TuningState, times: Vector) -> tuple[AxisRuns, CostOf]:
        runs, cost_of = as_it_is(state, times)
        return replace(runs, measured=runs.simulated), cost_of

    place.axis_runs = without
    try:
        yield
    finally:
        place.axis_runs = as_it_is


IS3_SOURCE = OnCorrectedTwin(
    name="is3_source",
    summary="gmfbo_estimated with corrected runs as a third source",
    reference=ThreeSources.reference,
    searching=ThreeSources(),
    refine=GMFBO_ESTIMATED.refine,
    correction=AROUND,
)

IS3_NONE = OnCorrectedTwin(
    name="is3_none",
    summary="gmfbo_estimated without a correction of trajectories",
    reference=GMFBO_ESTIMATED.reference,
    searching=UncorrectedGmfbo(),
    refine=GMFBO_ESTIMATED.refine,
)
