"""Multi-fidelity Bayesian optimisation that is no worse than without an unreliable twin.

Beside the multi-fidelity search a single-source one goes on in thought: its next query is run on
the axis unless the multi-fidelity surrogate knows its outcome already (standard deviation at most
c_1) and the query that it prefers instead is worth its cost (information on the least cost of the
axis, per cost, above c_2). Where the twin is asked instead, the single-source search goes on
with the expected outcome of its own query, a pseudo-observation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.methods.beliefs import (
    improve_each_source,
    incumbent_of,
    least_expected,
    observations_of,
    search_of,
)
from gmfbo.tuning.methods.mfbo_caei import TWIN_COST
from gmfbo.tuning.query.method import Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.model import SourceModel
    from gmfbo.surrogate.truncated import TruncatedModel

MOST_UNCERTAINTY, LEAST_INFORMATION = 0.1, 0.1
"""c_1, in standard deviations of the observed costs, and c_2 [nat per run of the axis]: the
authors' values, in their program and in all their experiments."""

REMEMBERED = 256
"""Steps whose pseudo-query is kept in memory; a study that is resumed works them out again."""


@dataclass(frozen=True)
class RobustMultiFidelity:
    """`mfbo_caei`, made robust by a single-source search that goes on beside it."""

    name: str = "rmfbo"
    summary: str = "mfbo_caei that asks the twin only where a single-source search loses nothing"
    reference: str = (
        "Mikkola, Martinelli, Filstroff and Kaski 2023, Multi-fidelity Bayesian optimization with "
        "unreliable information sources, arXiv:2210.13937"
    )
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Choose between the single-source and the multi-fidelity query."""
        from gmfbo.acquisition.relevance import information_per_cost

        data, model = observations_of(state, "IS1", "IS2"), _joint(state)
        own = _single_source_query(state, model)
        _, variance = model.predict(own[None, :], "IS1")
        if np.sqrt(variance[0]) > MOST_UNCERTAINTY * data.values.std():
            return Proposal("IS1", own, note="c_1: the outcome is not known well enough")
        query = improve_each_source(model, data, state, TWIN_COST)
        if query.source == "IS1":
            return query
        seed = int(rng.integers(2**31))
        told = information_per_cost(model, search_of(state), query.point, "IS2", seed)
        if told <= LEAST_INFORMATION:
            return Proposal("IS1", own, note="c_2: the twin tells too little")
        return query

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of the real axis over the box, by the multi-fidelity surrogate."""
        return least_expected(_joint(state), state)


def _joint(state: TuningState) -> TruncatedModel:
    from gmfbo.surrogate.truncated import TruncatedModel

    return TruncatedModel.fit(observations_of(state, "IS1", "IS2"))


def _single_source_query(state: TuningState, joint: TruncatedModel) -> NDArray[np.float64]:
    """Next query of the single-source search, with pseudo-observations where it was overruled."""
    pseudo = _pseudo_points(_Steps(state))
    return _improve(state, joint, pseudo)


def _improve(
    state: TuningState, joint: TruncatedModel, pseudo: Sequence[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Maximum of EI on real runs and pseudo-observations, point of shape (d,)."""
    from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
    from gmfbo.acquisition.maximise import maximise
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings
    from gmfbo.surrogate.observations import Observations

    rows: list[tuple[NDArray[np.float64], str, float]] = [
        (seen.point, "IS1", seen.objective) for seen in state.of("IS1")
    ]
    if pseudo:
        # Their values follow the surrogate as it learns.
        means, _ = joint.predict(np.stack(pseudo), "IS1")
        rows += [(point, "IS1", float(mean)) for point, mean in zip(pseudo, means, strict=True)]
    real = state.of("IS1")
    extra = state.extra_of(real, np.array([seen.objective for seen in real]))
    data = Observations.gather(rows, [*extra, *[0.0] * len(pseudo)])
    model: SourceModel = SourceModel.fit(data, SurrogateSettings(ard=True))
    acquisition = CostAwareExpectedImprovement(
        model, {"IS1": incumbent_of(state, data, "IS1")}, {"IS1": 1.0}
    )
    return maximise(acquisition, search_of(state), ["IS1"], data).point


@dataclass(frozen=True, eq=False)
class _Steps:
    """A state, equal to another one whose runs are the same: key of what is remembered."""

    state: TuningState

    def _key(self) -> tuple[object, ...]:
        runs = tuple(
            (seen.source, seen.objective, seen.outdated, *seen.point.tolist())
            for seen in self.state.of("IS1", "IS2")
        )
        return (*self.state.space.names, *self.state.space.bounds.ravel().tolist(), *runs)

    def __hash__(self) -> int:
        return hash(self._key())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Steps) and self._key() == other._key()


@lru_cache(maxsize=REMEMBERED)
def _pseudo_points(steps: _Steps) -> tuple[NDArray[np.float64], ...]:
    """Queries of the single-source search in whose place the twin was run."""
    state, points = steps.state, list[NDArray[np.float64]]()
    seen = state.of("IS1", "IS2")
    last = _last_twin_query(seen)
    if last is None:
        return ()
    # Without the last query of the twin and what came later: a shorter problem, remembered.
    # Gains held for a single proposal are not known later on, and play no part here.
    before = replace(state, observations=seen[:last], fixed={})
    points.extend(_pseudo_points(_Steps(before)))
    points.append(_improve(before, _joint(before), points))
    return tuple(points)


def _last_twin_query(seen: Sequence[Observation]) -> int | None:
    """Place of the last run of the twin that a method asked for: later than a real run."""
    real = False
    found = None
    for place, run in enumerate(seen):
        real = real or run.source == "IS1"
        if real and run.source == "IS2":
            found = place
    return found
