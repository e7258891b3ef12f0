"""Next experiment: safe references, and the one on which rivals differ most."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo import FmuTwin
from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.from_recordings import propose, rival_names
from gmfbo.diagnosis.experiment.menu_runs import (
    Played,
    make_menu,
    play,
    playing,
    recorded_limits,
    reference_input,
    whitener_of,
)
from gmfbo.diagnosis.experiment.reference_menu import RecordedLimits, reference_menu
from gmfbo.diagnosis.experiment.separation import Separation, differences, log_odds, separations
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.servo_recordings import GAINS, MODELS, SERVO, opened, opened_with

DELAY = {"transport_delay.delay": 1.5e-3}


@contextmanager
def ending(case: Case) -> Iterator[Case]:
    try:
        yield case
    finally:
        case.simulations.close()


def rival(case: Case, name: str, **values: float) -> Fitted:
    hypothesis = Hypothesis(case.setting, (Candidate(name, values),))
    found = fit(case.misfit, hypothesis, case.base.parameters)
    assert found is not None
    return found


def simulated_along(reference: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Case:
    """Open the servo's case on a recording of this reference, nothing missing."""
    time = np.arange(reference.size, dtype=np.float64) * 1e-3
    plain = Recording(time=time, signals={"reference": reference}, name="own.csv", parameters=GAINS)
    twin = FmuTwin(SERVO)
    rng = np.random.default_rng(3)
    with AugmentedTwin(twin, substeps=10, isolated=False) as simulator:
        run = simulator.run(simulator.plan(plain, {}), {})
    signals = {
        "reference": reference,
        "position": run.held["position"] + 3e-5 * rng.standard_normal(time.size),
        "torque_command": run.held["torque_command"] + 0.02 * rng.standard_normal(time.size),
    }
    recording = Recording(
        time=time, signals=signals, name="own.csv", parameters=GAINS, written_by="test"
    )
    return opened_with(twin, [recording])


limits = st.builds(
    RecordedLimits,
    start=st.floats(0.0, 1.0),
    low=st.floats(-2.0, -0.01),
    high=st.floats(1.01, 3.0),
    speed=st.floats(0.5, 20.0),
    acceleration=st.floats(5.0, 500.0),
    bandwidth=st.floats(2.0, 40.0),
    duration=st.floats(1.0, 5.0),
    step=st.sampled_from([0.0, 0.005]),
    spacing=st.sampled_from([1e-3, 2e-3]),
)


@settings(deadline=None, max_examples=40)
@given(limits=limits)
def test_no_reference_goes_beyond_what_was_recorded(limits: RecordedLimits) -> None:
    menu = reference_menu(limits)
    assert menu
    for entry in menu:
        values, slack = entry.values, 1.0 + 1e-9
        assert values.min() >= limits.low - 1e-9
        assert values.max() <= limits.high + 1e-9
        assert values[0] == pytest.approx(limits.start)
        assert values[-1] == pytest.approx(limits.start)
        if entry.name != "step":
            h = limits.spacing
            assert np.abs(np.diff(values)).max() / h <= slack * limits.speed
            assert np.abs(np.diff(values, 2)).max() / h**2 <= 1.001 * limits.acceleration


@settings(deadline=None, max_examples=40)
@given(limits=limits)
def test_patterns_one_after_the_other_keep_the_limits_where_they_meet(
    limits: RecordedLimits,
) -> None:
    menu, h = [e for e in reference_menu(limits) if e.name != "step"], limits.spacing
    for first, second in product(menu, repeat=2):
        values = np.concatenate([first.values, second.values])
        assert np.abs(np.diff(values)).max() / h <= (1.0 + 1e-9) * limits.speed
        assert np.abs(np.diff(values, 2)).max() / h**2 <= 1.001 * limits.acceleration


@pytest.mark.parametrize("start", [-1.0, 1.0])
def test_a_motion_may_begin_at_the_end_of_its_range(start: float) -> None:
    menu = reference_menu(RecordedLimits(start, -1.0, 1.0, 5.0, 100.0, 10.0, 2.0, 0.0, 1e-3))
    assert all(np.ptp(entry.values) > 0.5 for entry in menu)


def test_step_is_on_the_menu_only_where_one_was_recorded() -> None:
    plain = RecordedLimits(0.0, 0.0, 1.0, 5.0, 100.0, 10.0, 2.0, 0.0, 1e-3)
    stepped = RecordedLimits(0.0, 0.0, 1.0, 5.0, 100.0, 10.0, 2.0, 0.8, 1e-3)
    assert "step" not in {entry.name for entry in reference_menu(plain)}
    (step,) = [entry for entry in reference_menu(stepped) if entry.name == "step"]
    assert set(np.unique(step.values)) == {0.0, 0.8}


def test_limits_are_those_of_the_recorded_motion() -> None:
    time = np.arange(3000, dtype=np.float64) * 1e-3
    with ending(simulated_along(0.2 - 0.2 * np.cos(2.0 * np.pi * time))) as case:
        found = recorded_limits(case, case.base, "reference")
    # A cosine of 1 Hz: speed A w, acceleration A w^2; the loop hardly changes either.
    assert found.speed == pytest.approx(0.2 * 2.0 * np.pi, rel=0.05)
    assert found.acceleration == pytest.approx(0.2 * (2.0 * np.pi) ** 2, rel=0.1)
    assert (found.low, found.high) == pytest.approx((0.0, 0.4))
    assert 1.0 <= found.bandwidth < 3.0
    assert found.step == 0.0


def test_largest_step_is_a_limit_of_its_own() -> None:
    reference = np.where(np.arange(2000) < 300, 0.0, 0.4)
    with ending(simulated_along(reference)) as case:
        assert recorded_limits(case, case.base, "reference").step == pytest.approx(0.4)


@pytest.fixture(scope="module")
def delayed() -> Iterator[tuple[Case, list[Fitted]]]:
    with ending(opened(DELAY)) as case:
        delay = rival(case, "transport_delay", delay=1.5e-3)
        yield case, [delay, rival(case, "actuator_lag", time=1.5e-3)]


def test_rivals_are_told_apart_by_a_file_that_reads_back(
    delayed: tuple[Case, list[Fitted]], tmp_path: Path
) -> None:
    case, rivals = delayed
    recorded = case.simulations.records
    planned = propose(case, rivals, folder=tmp_path)
    assert case.simulations.records is recorded
    assert planned is not None
    assert planned.reference == "next.csv"
    assert planned.separates == ("transport_delay", "actuator_lag")
    assert planned.distance > planned.threshold
    assert planned.why.endswith(", tells transport delay from actuator lag")
    assert planned.predicted["transport_delay"].endswith(
        (" above actuator lag", " below actuator lag")
    )
    played = Recording.read(tmp_path / "next.csv", FmuTwin(SERVO))
    assert set(played.signals) == {"reference"}
    assert dict(played.parameters) == GAINS
    with AugmentedTwin(FmuTwin(SERVO)) as simulator:
        run = simulator.run(simulator.plan(played, {}), {})
    assert run.outcome.status == "ok"


def test_rivals_that_move_alike_are_said_to_stay_together(
    delayed: tuple[Case, list[Fitted]], tmp_path: Path
) -> None:
    case, (delay, _) = delayed
    planned = propose(case, [delay, delay], folder=tmp_path)
    assert planned is not None
    assert planned.separates == ()
    assert planned.reference == ""
    assert "no experiment on the menu separates them" in planned.why
    assert not (tmp_path / "next.csv").exists()


def test_one_hypothesis_needs_no_experiment(right_case: Case) -> None:
    assert propose(right_case, [right_case.base]) is None


def test_what_parameters_can_follow_is_no_distance(right_case: Case) -> None:
    reference = reference_input(right_case)
    assert reference == "reference"
    _, records = make_menu(right_case, right_case.base, reference)
    with playing(right_case, records):
        base = play(right_case, right_case.base)
        assert base is not None
        x = right_case.base.x * np.array([1.01, 1.1])
        moved = right_case.simulations.run([right_case.base.hypothesis.point(x)])[0]
        other = Played(moved, base.columns)
        whiteners = [whitener_of(right_case, k, run) for k, run in enumerate(base.simulated)]
        same = differences(whiteners, base, base)
        unfitted = differences(whiteners, other, Played(base.simulated, []))
        refitted = differences(whiteners, other, base)
        for entry in range(len(records)):
            raw = log_odds([unfitted[entry]])
            assert log_odds([same[entry]]) == 0.0
            assert log_odds([refitted[entry]]) < 0.02 * raw
            # Twice the same run: twice as sure.
            assert log_odds([unfitted[entry]] * 2) == pytest.approx(2.0 * raw)


def test_log_odds_are_the_mean_of_what_noise_makes_of_them(right_case: Case) -> None:
    """Of the likelihood ratio of two predictions, over recordings drawn from the first."""
    reference = reference_input(right_case)
    assert reference is not None
    _, records = make_menu(right_case, right_case.base, reference)
    with playing(right_case, records):
        one, two = (
            right_case.simulations.run([right_case.base.hypothesis.point(x)])[0]
            for x in (right_case.base.x, right_case.base.x * np.array([1.001, 1.01]))
        )
        whitener = whitener_of(right_case, 0, one[0])
    apart = whitener.whiten([a - b for a, b in zip(one[0].signals, two[0].signals, strict=True)])
    noise = np.random.default_rng(1).standard_normal((4000, apart.size))
    ratios = 0.5 * (np.sum((noise + apart) ** 2, axis=1) - np.sum(noise**2, axis=1))
    told = log_odds(differences([whitener], Played([one[0]], []), Played([two[0]], [])))
    assert told == pytest.approx(ratios.mean(), abs=4.0 * ratios.std() / np.sqrt(4000.0))


def test_the_best_run_tells_most_pairs_apart_then_all_of_them_by_most() -> None:
    def of(ab: float, ac: float, bc: float) -> Separation:
        return Separation((0,), {("a", "b"): ab, ("a", "c"): ac, ("b", "c"): bc})

    ranked = [of(20.0, 30.0, 16.0), of(90.0, 80.0, 1.0), of(90.0, 70.0, 2.0), of(14.0, 1.0, 1.0)]
    assert sorted(ranked, key=lambda one: one.worth, reverse=True) == ranked
    assert ranked[1].told_apart == {("a", "b"): 90.0, ("a", "c"): 80.0}


def test_a_pair_is_as_far_apart_as_the_nearer_of_its_two_ways(
    delayed: tuple[Case, list[Fitted]],
) -> None:
    case, rivals = delayed
    _, records = make_menu(case, rivals[0], "reference")
    with playing(case, records):
        played = [play(case, rival) for rival in rivals]
        a, b = (one for one in played if one is not None)
        whiteners = [whitener_of(case, k, run) for k, run in enumerate(a.simulated)]
        (both,) = separations(case, {"a": a, "b": b}, [(0, 1)])
    ways = [log_odds(differences(whiteners, *way)[:2]) for way in ((a, b), (b, a))]
    assert both.log_odds == {("a", "b"): min(ways)}


def test_effects_that_were_not_excited_get_a_reference_with_reversals(tmp_path: Path) -> None:
    time = np.arange(1500, dtype=np.float64) * 1e-3
    with ending(simulated_along(0.5 * np.maximum(time - 0.2, 0.0))) as case:
        assert case.setting.excitation.reversals == 0
        planned = propose(case, [case.base], ["coulomb_friction"], tmp_path)
    assert planned is not None
    assert planned.separates == ("coulomb_friction",)
    assert planned.why.endswith(", excites what was not excited so far: coulomb friction")
    played = Recording.read(tmp_path / "next.csv", FmuTwin(SERVO)).signal("reference")
    moves = np.sign(np.diff(played))
    assert {-1.0, 1.0} <= set(moves)


def test_effect_that_no_safe_reference_excites_is_said_to_need_more() -> None:
    time = np.arange(2000, dtype=np.float64) * 1e-3
    # Six degrees: gravity needs twenty.
    with ending(simulated_along(0.05 * np.sin(2.0 * np.pi * time))) as case:
        planned = propose(case, [case.base], ["gravity_torque"])
    assert planned is not None
    assert planned.reference == ""
    assert "20 degrees" in planned.why


def test_open_loop_twin_has_no_reference_to_play() -> None:
    time = np.arange(1000, dtype=np.float64) * 1e-3
    current = np.sin(2.0 * np.pi * 2.0 * time)
    plain = Recording(time=time, signals={"current": current}, name="bench.csv")
    twin = FmuTwin(MODELS / "motor_bench.toml")
    with AugmentedTwin(twin) as simulator:
        run = simulator.run(simulator.plan(plain, {}), {})
    signals = {"current": current, "position": run.held["position"]}
    recording = Recording(time=time, signals=signals, name="bench.csv", written_by="test")
    with ending(opened_with(twin, [recording])) as case:
        assert reference_input(case) is None
        assert propose(case, [case.base, case.base]) is None
        assert propose(case, [case.base], ["coulomb_friction"]) is None


def test_rivals_of_one_name_are_numbered(right_case: Case) -> None:
    certain = {one.name for one in right_case.setting.uncertain}
    assert rival_names([right_case.base, right_case.base], certain) == [
        "parameters",
        "parameters (2)",
    ]
