"""Hypotheses as vectors and points, and simulators that give the same whatever their number."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.diagnosis.case.held_out_split import split_of
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis, Setting
from gmfbo.diagnosis.runs.scored_record import scored_record
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.physics import CATALOGUE
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.uncertain import Uncertain
from tests.diagnosis.short_recordings import SERVO, moves, multisine, open_small, triangle
from tests.physics.excitations import TYPICAL

INERTIA = Uncertain("inertia", 0.12, 0.05, 0.3)
VISCOUS = Uncertain("viscous", 0.5, 0.0, 2.0)
SETTING = Setting((INERTIA, VISCOUS), TYPICAL, "inertia")
COULOMB = {"coulomb_friction.level": 0.2, "coulomb_friction.deflection": 1e-6}


def starting(*names: str) -> Hypothesis:
    """Hypothesis with each effect at its first start."""
    effects = [Candidate(n, dict(CATALOGUE[n].starts(TYPICAL)[0])) for n in names]
    return Hypothesis(SETTING, tuple(effects))


@given(st.lists(st.sampled_from(sorted(CATALOGUE)), min_size=0, max_size=3, unique=True))
def test_a_vector_and_its_hypothesis_are_one_and_the_same(names: list[str]) -> None:
    hypothesis = starting(*names)
    x = hypothesis.start({"inertia": 0.1, "viscous": 0.4})
    low, high = hypothesis.bounds
    assert x.size == len(hypothesis.names) == low.size == hypothesis.scales.size
    assert np.all((low < x) & (x < high))
    np.testing.assert_array_equal(hypothesis.at(x).start(hypothesis.parameters(x)), x)
    assert hypothesis.parameters(x) == pytest.approx({"inertia": 0.1, "viscous": 0.4})
    assert np.all(hypothesis.prior > 0.0)


@given(st.sampled_from(sorted(CATALOGUE)))
def test_a_point_holds_each_fitted_value_under_its_name_in_physics(name: str) -> None:
    hypothesis = starting(name)
    point = hypothesis.point(hypothesis.start({}))
    for parameter in hypothesis.effects[0].parameters:
        value = point.physics[f"{name}.{parameter.name}"]
        start = hypothesis.effects[0].values[parameter.name]
        assert value == pytest.approx(start, rel=1e-4, abs=1e-4 * parameter.scale(TYPICAL))


@pytest.mark.parametrize("name", ["backlash", "torsional_compliance"])
def test_a_load_behind_a_gap_or_shaft_is_taken_out_of_the_twins_inertia(name: str) -> None:
    hypothesis = starting(name)
    point = hypothesis.point(hypothesis.start({"inertia": 0.15}))
    moved = point.physics[f"{name}.load_inertia"]
    assert moved > 0.0
    assert point.parameters["inertia"] + moved == pytest.approx(0.15)
    assert point.physics[f"{name}.shaft_inertia"] == point.parameters["inertia"]


def test_a_load_is_taken_out_of_the_nominal_inertia_where_that_is_certain() -> None:
    hypothesis = replace(starting("backlash"), setting=replace(SETTING, uncertain=(VISCOUS,)))
    point = hypothesis.point(hypothesis.start({}))
    whole = point.parameters["inertia"] + point.physics["backlash.load_inertia"]
    assert whole == pytest.approx(TYPICAL.shaft_inertia)


def test_a_load_larger_than_the_whole_leaves_some_inertia() -> None:
    hypothesis = starting("backlash")
    x = hypothesis.start({"inertia": 0.06})
    x[hypothesis.names.index("backlash.load_inertia")] = 0.1
    assert 0.0 < hypothesis.point(x).parameters["inertia"] < 1e-3


def test_an_effect_of_one_recording_is_off_in_the_others() -> None:
    candidate = Candidate("constant_torque_offset", {"level": 0.5}, only=1)
    hypothesis = Hypothesis(SETTING, (candidate,))
    point = hypothesis.point(hypothesis.start({}))
    assert [point.physics_in(k) for k in range(3)] == [{}, dict(point.physics), {}]


@pytest.fixture(scope="module")
def simulations() -> Iterator[tuple[Simulations, Simulations]]:
    """One simulator, and two, along the same two recordings."""
    twin = SERVO.twin()
    recordings = SERVO.recordings({}, seconds=0.4)
    with AugmentedTwin(twin, isolated=False) as first:
        records = [
            scored_record(r, first.plan(r, {}), ["position", "torque_command"], 0.0)
            for r in recordings
        ]
    one = Simulations(lambda: AugmentedTwin(twin), records, 1)
    two = Simulations(lambda: AugmentedTwin(twin), records, 2)
    with one, two:
        yield one, two


def test_two_simulators_give_the_bits_of_one(simulations: tuple[Simulations, Simulations]) -> None:
    points = [Point({"inertia": i}, COULOMB) for i in (0.009, 0.01, 0.012)]
    one, two = (s.run(points) for s in simulations)
    for a, b in zip(one, two, strict=True):
        for x, y in zip(a, b, strict=True):
            for own, other in zip(x.signals, y.signals, strict=True):
                np.testing.assert_array_equal(own, other)


def counted(simulations: Simulations, points: Sequence[Point]) -> int:
    """Simulations that these points take."""
    before = simulations.runs
    simulations.run(points)
    return simulations.runs - before


def test_each_run_is_counted(simulations: tuple[Simulations, Simulations]) -> None:
    two, told = simulations[1], []
    two.on_run = lambda: told.append(1)
    made = counted(two, [Point({"inertia": 0.0101}), Point({"inertia": 0.0102})])
    two.on_run = lambda: None
    assert made == len(told) == 4


def test_what_was_simulated_of_late_is_not_simulated_again(
    simulations: tuple[Simulations, Simulations],
) -> None:
    one = simulations[0]
    point = Point({"inertia": 0.0103}, COULOMB)
    first = one.run_here(point)
    assert counted(one, [point]) == 0
    for run, again in zip(first, one.run_here(Point({"inertia": 0.0103}, COULOMB)), strict=True):
        assert again.response is run.response
    # In the second recording alone: the first is the twin without physics.
    assert counted(one, [replace(point, only={"coulomb_friction": 1})]) == 1
    # Negative controls: other physics, another parameter, something added to what drives it.
    assert counted(one, [replace(point, physics={"coulomb_friction.level": 0.21})]) == 2
    assert counted(one, [replace(point, parameters={"inertia": 0.0104})]) == 2
    before = one.runs
    torque = np.zeros(one.records[0].plan.grid.size)
    for _ in range(2):
        one.run_one(point, 0, excitation={"torque": torque})
    assert one.runs - before == 2


def test_an_effect_of_one_recording_changes_that_one_alone(
    simulations: tuple[Simulations, Simulations],
) -> None:
    one = simulations[0]
    plain, both, second = one.run(
        [Point(), Point({}, COULOMB), Point({}, COULOMB, {"coulomb_friction": 1})]
    )
    np.testing.assert_array_equal(second[0].signals[0], plain[0].signals[0])
    np.testing.assert_array_equal(second[1].signals[0], both[1].signals[0])
    assert not np.array_equal(second[1].signals[0], plain[1].signals[0])


def test_signals_are_read_at_their_own_times(simulations: tuple[Simulations, Simulations]) -> None:
    one = simulations[0]
    run = one.run_one(Point(), 0)
    original = one.records
    slow = replace(
        original[0].signals[0],
        time=original[0].signals[0].time[::4],
        values=original[0].signals[0].values[::4],
    )
    try:
        one.replace_records([replace(original[0], signals=(slow,)), original[1]])
        (values,) = one.read(run.response, 0)
    finally:
        one.replace_records(original)
    np.testing.assert_array_equal(values, run.signals[0][::4])


@pytest.mark.parametrize(
    ("references", "held_out"),
    [
        ((multisine, moves, triangle), {"rec0.csv", "rec1.csv", "rec2.csv"}),
        ((multisine,), set()),
    ],
)
def test_whole_recordings_are_held_out_from_three_on_and_last_stretches_before(
    references: tuple[object, ...], held_out: set[str]
) -> None:
    recordings = SERVO.recordings({}, references, seconds=2.6)  # type: ignore[arg-type]
    case = open_small(SERVO.twin(), recordings)
    try:
        split = split_of(case, [], case.base)
    finally:
        case.simulations.close()
    windows = range(len(case.budget.windows))
    assert sorted((*split.fitted, *split.held_out)) == list(windows)
    assert split.fitted
    assert split.held_out
    own = {case.budget.windows[i].record for i in split.held_out}
    if held_out:
        assert set(split.names_held_out) < held_out
        assert not own & {case.budget.windows[i].record for i in split.fitted}
    else:
        assert split.held_out == (len(case.budget.windows) - 1,)
        assert split.names_held_out[0].startswith("rec0.csv [")


def test_the_recording_that_shows_a_small_effect_best_is_fitted() -> None:
    references = (multisine, moves, triangle, moves)
    case = open_small(SERVO.twin(), SERVO.recordings({}, references, seconds=2.6))

    def change(*in_each: float) -> tuple[np.ndarray, ...]:
        pairs = zip(case.budget.windows, case.base.residual, strict=True)
        return tuple(np.full(block.size, in_each[window.record]) for window, block in pairs)

    try:
        strong, weak = change(3.0, 1.0, 2.0, 1.5), change(0.0, 0.0, 0.1, 0.0)
        assert split_of(case, [strong], case.base).names_held_out == ("rec2.csv",)
        assert split_of(case, [strong, weak], case.base).names_held_out == ("rec3.csv",)
    finally:
        case.simulations.close()


def test_a_recording_without_which_a_value_would_be_open_is_fitted() -> None:
    """Of what is known from two recordings, each about another direction, both are needed."""
    references = (multisine, moves, triangle, moves)
    case = open_small(SERVO.twin(), SERVO.recordings({}, references, seconds=2.6))

    # The first value is told by the first recording, the second one by the third alone.
    shares = np.array([[1.0, 1e-3, 1e-3, 0.5], [1e-3, 1e-3, 1.0, 1e-3]])
    try:
        pairs = list(zip(case.budget.windows, case.base.residual, strict=True))
        sensitivity = tuple(np.outer(shares[:, w.record], 1e3 * np.ones(b.size)) for w, b in pairs)
        strong = tuple(np.full(b.size, (3.0, 1.0, 2.0, 1.5)[w.record]) for w, b in pairs)
        model = replace(case.base, sensitivity=sensitivity)
        assert split_of(case, [strong], case.base).names_held_out == ("rec2.csv",)
        assert split_of(case, [strong], model).names_held_out == ("rec3.csv",)
    finally:
        case.simulations.close()


def test_a_fit_recovers_parameters_and_friction_from_noisy_recordings_within_a_hundredth() -> None:
    case = open_small(SERVO.twin(), SERVO.recordings(COULOMB))
    try:
        start = Candidate("coulomb_friction", {"level": 0.1})
        hypothesis = Hypothesis(case.setting, (start,))
        found = fit(case.misfit, hypothesis, {"inertia": 0.013, "viscous": 0.08})
    finally:
        case.simulations.close()
    assert found is not None
    assert found.hypothesis.effects[0].values["level"] == pytest.approx(0.2, rel=0.01)
    assert found.parameters["inertia"] == pytest.approx(SERVO.truth["inertia"], rel=0.01)
    # Friction takes most of what damps: of 0.2 N m a hundredth of viscous torque is 0.002 N m.
    assert found.parameters["viscous"] == pytest.approx(SERVO.truth["viscous"], abs=0.002)
