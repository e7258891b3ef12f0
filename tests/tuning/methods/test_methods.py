"""Methods on a hand-made state: what they may propose and by what they decide."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from gmfbo.objective import METRICS, PAPER_WEIGHTS, Objective
from gmfbo.recordings.store.trial import SourceName
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.experiment.experiment import ReferenceExperiment
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.methods import METHODS, find_method
from gmfbo.tuning.methods.beliefs import corrected_and_twin
from gmfbo.tuning.query.method import Method, Proposal
from gmfbo.tuning.study_file.reference_section import ReferenceSection

SPACE = GainSpace((Gain("Kp", 10.0, 90.0), Gain("Kd", 1.0, 9.0)))

EXPERIMENT = ExperimentSeries(
    (ReferenceExperiment.from_section(ReferenceSection(), "position", folder=Path()),)
)
OBJECTIVE = Objective.from_samples(
    PAPER_WEIGHTS, {name: np.array([0.1, 0.2, 0.3]) for name in METRICS}, horizon=1.0
)


def cost(point: np.ndarray) -> float:
    return float(np.sum((point - np.array([0.7, 0.3])) ** 2) - 0.1)


def state_of(
    space: GainSpace = SPACE, fixed: Mapping[str, float] | None = None, real: int = 5
) -> TuningState:
    """Real runs, a biased twin, and corrected runs that are half as wrong."""
    rng = np.random.default_rng(8)
    seen: list[Observation] = []

    def see(source: SourceName, point: np.ndarray, bias: float, parent: int | None) -> None:
        value, twin = cost(point) + bias, cost(point) + 0.2
        seen.append(
            Observation(
                number=len(seen) + 1,
                source=source,
                point=point,
                objective=value,
                scaled=value + 1.0,
                parent=parent,
                uncorrected=twin if source == "IS3" else None,
                uncorrected_scaled=twin + 1.0 if source == "IS3" else None,
            )
        )

    for point in rng.random((10, 2)):
        see("IS2", space.to_unit(space.from_unit(point)), 0.2, None)
    for point in rng.random((real, 2)):
        see("IS1", space.to_unit(space.from_unit(point)), 0.0, None)
        number = len(seen)
        see("IS2", seen[-1].point, 0.2, number)
        for _ in range(4):
            near = np.clip(seen[number - 1].point + 0.05 * rng.standard_normal(2), 0.0, 1.0)
            see("IS3", space.to_unit(space.from_unit(near)), 0.1, number)
    return TuningState(space, tuple(seen), fixed or {}, (), EXPERIMENT, OBJECTIVE)


def propose(method: Method, state: TuningState) -> Proposal:
    proposal = method.propose(state, np.random.default_rng(1))
    assert proposal is not None
    return proposal


@functools.cache
def proposed(name: str) -> Proposal:
    """What a method proposes first, which is asked once."""
    return propose(find_method(name), state_of())


@pytest.fixture(params=sorted(METHODS))
def method(request: pytest.FixtureRequest) -> Method:
    return find_method(request.param)


def test_each_method_says_what_it_does_and_where_it_comes_from(method: Method) -> None:
    assert method.summary
    assert "\n" not in method.summary
    assert any(character.isdigit() for character in method.reference)


def test_proposals_lie_in_the_box_and_are_new(method: Method) -> None:
    state = state_of()
    proposal = proposed(method.name)
    assert np.all((proposal.point >= 0.0) & (proposal.point <= 1.0))
    taken = np.array([seen.point for seen in state.of(proposal.source)])
    assert np.abs(taken - proposal.point).max(axis=1).min() > 1e-6


def test_proposals_follow_from_state_and_stream_alone(method: Method) -> None:
    first, second = proposed(method.name), propose(method, state_of())
    np.testing.assert_array_equal(first.point, second.point)
    assert first.source == second.source


def test_held_gains_are_held(method: Method) -> None:
    proposal = propose(method, state_of(fixed={"Kd": 3.0}))
    assert SPACE.from_unit(proposal.point)[1] == pytest.approx(3.0)


def test_integer_gains_are_integers(method: Method) -> None:
    space = GainSpace((Gain("Kp", 10.0, 90.0), Gain("taps", 1, 9, integer=True)))
    taps = space.from_unit(propose(method, state_of(space)).point)[1]
    assert taps == round(taps)


def test_the_recommendation_is_near_the_minimum(method: Method) -> None:
    point, mean, std = method.recommend(state_of(real=12))
    np.testing.assert_allclose(point, [0.7, 0.3], atol=0.12)
    assert mean == pytest.approx(-0.1, abs=0.08)
    assert std >= 0.0


def test_single_source_methods_ask_the_axis_only() -> None:
    for name in ("random", "bo_ei"):
        assert propose(find_method(name), state_of()).source == "IS1"
        assert find_method(name).correction is None


def test_the_printed_mismatch_is_the_mean_ratio_of_normalised_costs() -> None:
    state = state_of()
    corrected = np.array([seen.objective for seen in state.of("IS3")])
    expected = np.mean(np.abs(0.1 / corrected))
    assert propose(find_method("gmfbo_paper"), state).mismatch == pytest.approx(expected)


def test_the_default_mismatch_is_the_median_ratio_of_scaled_costs() -> None:
    state = state_of()
    corrected = np.array([seen.scaled for seen in state.of("IS3")])
    expected = np.median(0.1 / corrected)
    assert propose(find_method("gmfbo"), state).mismatch == pytest.approx(expected)


def test_without_corrected_runs_there_are_no_pairs() -> None:
    corrected, twin = corrected_and_twin(
        TuningState(SPACE, (), {}, (), EXPERIMENT, OBJECTIVE), scaled=True
    )
    assert corrected.shape == twin.shape == (0,)


def test_a_users_method_enters_the_table_without_touching_the_loop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Corner:
        name = "corner"
        summary = "the upper corner"
        reference = "test 2026"
        correction = None

        def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
            return Proposal("IS1", np.ones(len(state.space)))

        def recommend(self, state: TuningState) -> tuple[np.ndarray, float, float]:
            return np.ones(len(state.space)), 0.0, 0.0

    monkeypatch.setitem(METHODS, "corner", Corner())
    assert propose(find_method("corner"), state_of()).point.tolist() == [1.0, 1.0]
