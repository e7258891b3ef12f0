"""Cases of the blind benchmark: reproducible, and their answers apart."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording
from gmfbo.physics import CATALOGUE
from tests.blind.cases import make_case
from tests.blind.generate import CASES, answer_path, check_hashes, generate
from tests.blind.hidden import EFFECTS
from tests.blind.machines import MACHINES, variation
from tests.blind.oracle import Experiment, Oracle
from tests.blind.outside import OUTSIDE
from tests.blind.plan import SHARES, Plan, make_plan
from tests.blind.references import SHAPES
from tests.blind.truth import TrueRun, simulate
from tests.blind.windows import windows_of


def test_the_mix_of_the_whole_benchmark_is_the_one_that_is_stated() -> None:
    plans = make_plan(CASES, 5)
    assert CASES == 510
    assert Counter(plan.kind for plan in plans) == SHARES
    assert SHARES["null"] + SHARES["stressed_null"] + SHARES["decoy"] == 150
    assert {plan.machine for plan in plans} == set(MACHINES)
    assert len({plan.effects for plan in plans if plan.kind == "outside"}) == len(OUTSIDE)


def test_every_effect_of_the_catalogue_is_hidden_alone_at_least_eight_times() -> None:
    """A third of the cases of each lies below the limit, around it and above."""
    singles = [p for p in make_plan(CASES, 5) if p.kind == "single" and p.is_within_reach]
    counts = Counter(plan.effects[0] for plan in singles)
    assert set(counts) == set(CATALOGUE) == set(EFFECTS)
    assert min(counts.values()) >= 8
    bands = Counter((plan.effects[0], plan.band) for plan in singles)
    assert set(bands.values()) <= {2, 3, 4}
    assert len(bands) == 3 * len(counts)


def test_what_is_an_uncertain_parameter_is_hidden_only_where_it_is_measured() -> None:
    for plan in make_plan(CASES, 6):
        if plan.kind == "single" and EFFECTS[plan.effects[0]].measured_only:
            assert not MACHINES[plan.machine].free


def test_the_laws_outside_the_catalogue_are_at_every_place() -> None:
    places = Counter(law.port for law in OUTSIDE.values())
    assert set(places) == {"torque", "command", "sensor"}
    assert not set(OUTSIDE) & set(CATALOGUE)


@pytest.mark.parametrize("cases", [1, 7, 20, 50])
def test_a_plan_has_as_many_cases_as_asked_and_follows_its_seed(cases: int) -> None:
    assert len(make_plan(cases, 1)) == cases
    assert make_plan(cases, 1) == make_plan(cases, 1)


def test_effects_beyond_the_ports_are_marked_as_out_of_reach() -> None:
    assert not Plan("single", "servo_none", ("coulomb_friction",)).is_within_reach
    assert not Plan("single", "servo_torque", ("sensor_lag",)).is_within_reach
    assert Plan("single", "bench", ("actuator_lag",)).is_within_reach


def test_a_case_is_the_same_for_the_same_seed(tmp_path: Path) -> None:
    """Answer, twin file and recordings, to the byte; another index is another case."""
    plan = Plan("stressed_null", "servo", details=("clock_skew",))
    texts = []
    for name, index in (("a/000", 0), ("b/000", 0), ("c/000", 1)):
        folder = tmp_path / name
        answer = make_case(plan, 3, index, folder).text()
        files = sorted(path for path in folder.iterdir())
        texts.append([answer, *(path.read_text(encoding="utf-8") for path in files)])
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_a_stressed_null_says_which_fixed_parameter_is_wrong(tmp_path: Path) -> None:
    """A servo's current lag is off by some; with a lag that the twin doesn't have nothing is."""
    answers = [
        make_case(Plan("stressed_null", name, details=("torque_lag",)), 3, 0, tmp_path / name)
        for name in ("servo", "bench")
    ]
    fixed = answers[0].details["fixed"]
    assert (fixed["name"], fixed["believed"]) == ("torque_lag", 5e-4)
    assert 0.8 <= fixed["true"] / fixed["believed"] <= 1.3
    assert "fixed" not in answers[1].details


def test_the_recordings_of_a_null_are_its_twin_within_noise(tmp_path: Path) -> None:
    """By the true parameters: the reading within its quantum and jitter, row by row."""
    folder = tmp_path / "000"
    answer = make_case(Plan("null", "servo"), 11, 0, folder)
    values = {name: entry["true"] for name, entry in answer.parameters.items()}
    with FmuTwin(folder / "twin.toml") as twin:
        for path in sorted(folder.glob("rec*.csv")):
            recording = Recording.read(path, twin)
            run = twin.run({}, recording, parameters=values)
            error = recording.signals["position"] - run.signal("position")
            assert np.sqrt(np.mean(error**2)) < 2e-4
            assert np.ptp(recording.signals["position"]) > 0.1


def test_answers_stay_out_of_the_folders_of_the_cases(tmp_path: Path) -> None:
    """Nor does any file of a case name an effect, a kind of case or the seed."""
    generate(2, 2, tmp_path)
    for index in range(2):
        folder = tmp_path / "cases" / f"{index:03d}"
        files = sorted(path.name for path in folder.rglob("*"))
        assert files[-1] == "twin.toml"
        assert all(re.fullmatch(r"rec\d\.csv", name) for name in files[:-1])
        assert len(files) >= 5
        text = "".join(path.read_text(encoding="utf-8") for path in folder.iterdir())
        assert not [name for name in (*EFFECTS, *SHARES, "seed", "hidden") if name in text]
        assert not answer_path(tmp_path, index).is_relative_to(tmp_path / "cases")
    check_hashes(tmp_path)
    before = (tmp_path / "answers.sha256").read_bytes()
    generate(2, 2, tmp_path)  # nothing is made again
    assert (tmp_path / "answers.sha256").read_bytes() == before
    with pytest.raises(ValueError, match="holds the benchmark"):
        generate(3, 2, tmp_path)
    answer_path(tmp_path, 1).write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match=r"001\.json is not the answer that was hashed"):
        check_hashes(tmp_path)


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    rng = np.random.default_rng(0)
    machine = MACHINES["servo"]
    values = variation(machine, rng)
    experiments = [
        Experiment(shape, machine.strokes[shape] * SHAPES[shape](rng, 1500), {})
        for shape in ("multisine", "triangle")
    ]
    return Oracle(machine, values, experiments, seed=1)


@pytest.mark.slow
def test_the_oracle_gains_nothing_by_wrong_parameters(oracle: Oracle) -> None:
    changed = {"inertia": 1.1 * oracle.values["inertia"], "viscous": 0.7 * oracle.values["viscous"]}
    assert oracle.gain({}) == 0.0
    assert oracle.gain(changed) < 0.1


@pytest.mark.slow
def test_the_gain_of_a_small_effect_grows_with_its_square(oracle: Oracle) -> None:
    gains = [oracle.gain({"wave_1": size, "wave_number_1": 11.0}) for size in (1e-3, 2e-3)]
    assert gains[0] > 1.0
    assert gains[1] == pytest.approx(4.0 * gains[0], rel=0.1)


@pytest.mark.slow
def test_noise_is_part_of_what_an_effect_does(oracle: Oracle) -> None:
    """It drives a command into a limit that it would not reach, and bridges a dead zone."""
    peak = max(float(np.max(np.abs(run.new))) for run in oracle.clean)
    limit, zone = {"drive_limit": 1.001 * peak}, {"dead_width": 0.005}
    quiet, loud = _under_noise(oracle, 0.0), _under_noise(oracle, 20.0)
    assert quiet.gain(limit) == 0.0
    assert loud.gain(limit) > 10.0
    assert 0.02 * quiet.gain(zone) < loud.gain(zone) < 0.5 * quiet.gain(zone)


def _under_noise(oracle: Oracle, factor: float) -> Oracle:
    """The same plant under another noise, judged as the first one."""
    jitter = factor * np.hypot(oracle.machine.jitter, oracle.machine.quantum / np.sqrt(12.0))
    under = replace(oracle, machine=replace(oracle.machine, jitter=float(jitter), quantum=0.0))
    under.__dict__["_whitening"] = oracle._whitening
    return under


def test_in_open_loop_a_push_is_worth_what_the_noise_of_the_command_leaves_of_it() -> None:
    """A push p in n rows of white torque noise s: no unbiased test knows more than n (p / s)^2.

    Taken as independent, the frequencies of a drift would give about a hundred times as much.
    """
    rng = np.random.default_rng(0)
    machine = MACHINES["bench"]
    values = variation(machine, rng)
    reference = machine.strokes["multisine"] * SHAPES["multisine"](rng, 2500)
    oracle = Oracle(machine, values, [Experiment("multisine", reference, {})], seed=1)
    push = 3e-4
    known = 2500 * (push / (values["torque_gain"] * machine.command_noise)) ** 2
    assert 0.2 * known < oracle.gain({"push": push}) < 1.5 * known


def test_the_oracle_calls_a_lag_as_in_a_stressed_null_no_physics(oracle: Oracle) -> None:
    """A tenth of a millisecond costs one standard deviation; ten of them are an effect."""
    lag = oracle.values["torque_lag"]
    assert oracle.gain({"torque_lag": lag + 1e-4}) < 1.5
    assert oracle.gain({"torque_lag": lag + 1.5e-3}) > 60.0


def test_windows_are_where_the_velocity_turns_and_where_something_acts() -> None:
    t = np.arange(2000) * 1e-3
    velocity = np.sin(2.0 * np.pi * t)
    active = np.zeros(2000)
    active[300:305] = active[310] = active[900] = 0.6
    nothing = np.zeros(2000)
    run = TrueRun(nothing, nothing, nothing, nothing, velocity, active)
    turns = windows_of("reversals", run, 0.1)
    assert [0.5 * (start + end) for start, end in turns] == pytest.approx([0.5, 1.0, 1.5], abs=2e-3)
    assert windows_of("active", run, 0.1) == [(0.3, 0.311), (0.9, 0.901)]
    assert windows_of("", run, 0.1) == []


def test_friction_shows_at_the_reversals_of_a_true_run(oracle: Oracle) -> None:
    one = oracle.experiments[1]
    run = simulate(
        {**oracle.values, "friction_positive": 0.1, "friction_negative": 0.1}, one.reference
    )
    assert 3 <= len(windows_of("reversals", run, 0.1)) <= 6
