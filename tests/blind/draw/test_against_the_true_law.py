"""Errors, sets and widths beside the true law, each against what is known in closed form."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blind.cases import make_case
from tests.blind.draw.errors_of_the_true_law import errors_of, joint_ratio, nrmse, told_errors
from tests.blind.draw.fit_of_the_true_law import TrueLaw
from tests.blind.draw.judging import judge
from tests.blind.draw.law_coordinates import FREE, coordinates, reported
from tests.blind.draw.narrowest_intervals import narrowest, standard_error
from tests.blind.draw.noise_of_a_case import driven, noise_in, noise_of, of_a_stretch
from tests.blind.draw.prediction_errors import command_of
from tests.blind.draw.remade import Remade, known
from tests.blind.draw.rigs import Rig
from tests.blind.draw.separated_sets import Separation, partners_of, separated, statements_of
from tests.blind.draw.table_against_the_true_law import quantile_interval, table
from tests.blind.draw.test_judging import answer, said
from tests.blind.hidden import EFFECTS, Changes
from tests.blind.machines import MACHINES
from tests.blind.oracle import Experiment, Oracle
from tests.blind.outside import LAWS_OUTSIDE
from tests.blind.plan import Plan
from tests.blind.recording import Logger
from tests.blind.references import SHAPES
from tests.blind.truth import PREROLL, Vector, simulate

ROWS = 900


def case_of(machine: str = "servo", **changes: float) -> Remade:
    """One recording of a machine with something hidden."""
    own = MACHINES[machine]
    wave = SHAPES["multisine"](np.random.default_rng(1), ROWS)
    gains = {name: own.truth[name] for name in own.gains}
    experiments = [Experiment("multisine", own.strokes["multisine"] * wave, gains)]
    oracle = Oracle(own, own.truth, experiments, 3)
    logger = Logger("new")
    rng = np.random.default_rng(5)
    return Remade(own, own.truth, changes, experiments, logger, Rig(), oracle, rng)


def law_of(case: Remade, *laws: str) -> TrueLaw:
    """The plant with the values of some laws and the twin's parameters free."""
    return TrueLaw(case, coordinates(case.plant, laws, case.machine.free))


@pytest.mark.parametrize(
    "plan",
    [
        Plan("pair", "servo", ("gravity_torque", "coulomb_friction")),
        Plan("decoy", "axis", details=("friction_without_reversal",)),
    ],
)
def test_a_case_drawn_again_has_the_recordings_of_its_files(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sizes are the answer's: here they are not searched for."""
    monkeypatch.setattr("tests.blind.cases.size_for_gain", lambda *_: 0.1)
    monkeypatch.setattr(Oracle, "gain", lambda *_, **__: 100.0)
    made = make_case(plan, 7, 2, tmp_path)
    again = known(plan, json.loads(made.text()), np.random.default_rng([7, 3]))
    for path, columns in zip(sorted(tmp_path.glob("rec*.csv")), again.recordings(), strict=True):
        lines = path.read_text(encoding="utf-8").splitlines()
        cells = [line.split(",")[-2:] for line in lines if line[0] not in "#t"]
        assert np.array_equal(np.array(cells, dtype=float), columns)


def test_every_law_of_the_library_has_free_values() -> None:
    assert set(EFFECTS) == set(FREE)
    assert not set(LAWS_OUTSIDE) & set(FREE)


def test_a_motor_and_its_load_are_told_as_one_inertia() -> None:
    plant = {"inertia": 3.0, "load_inertia": 2.0, "shaft_stiffness": 5.0}
    names = {"plant.inertia": "inertia"}
    assert reported("plant.inertia", plant, {}, names) == 5.0
    assert reported("torsional_compliance.load_inertia", plant, {}, names) == 2.0


# ---- errors


def test_the_ratio_weighs_each_signal_by_its_noise() -> None:
    noise = {"position": 1.0, "command": 10.0}
    true = {"position": 1.0, "command": 10.0}
    assert joint_ratio(true, true, noise) == 1.0
    told = {"position": 3.0, "command": 10.0}
    assert joint_ratio(told, true, noise) == pytest.approx(np.sqrt(10.0 / 2.0))
    assert joint_ratio(told, {"position": 1.5}, noise) == 2.0  # the only signal of both


def test_an_error_is_the_root_mean_square_over_the_range() -> None:
    y = np.array([0.0, 1.0, 2.0, 4.0])
    assert nrmse([y[:2], y[2:]], [y[:2] + 0.2, y[2:] - 0.2]) == pytest.approx(0.05)


def test_the_twin_stays_where_nothing_is_told() -> None:
    run = {"parameters_only": 0.4, "augmented": None}
    signals = {"position": {"parameters_only": 0.3, "augmented": None, "free_run": run}}
    assert told_errors({"fit": {"signals": signals}}, False) == {"position": 0.3}
    assert told_errors({"fit": {"signals": signals}}, True) == {"position": 0.4}
    signals["position"] |= {"augmented": 0.1, "free_run": None}
    assert told_errors({"fit": {"signals": signals}}, False) == {"position": 0.1}
    assert told_errors({"fit": {"signals": signals}}, True) == {}


@pytest.mark.parametrize("machine", ["servo", "bench"])
def test_a_fit_finds_the_plant_that_made_recordings_without_noise(machine: str) -> None:
    case = case_of(machine, drag=2e-3)
    law = law_of(case, "quadratic_drag")
    moved = np.array([0.01, -0.02, 0.03])
    recorded = case.clean(law.free.at(moved))
    scales = [1e-4, 1e-2][: law.slopes[0].shape[1]]
    found = law.fitted(recorded, [0], scales)
    assert found == pytest.approx(moved, abs=2e-5)
    assert max(errors_of(law, recorded, found, [0]).values()) < 1e-6


def test_a_true_law_leaves_the_noise_that_it_was_recorded_with() -> None:
    case = case_of(friction_positive=0.05, friction_negative=0.05)
    law = law_of(case, "coulomb_friction")
    recorded = [np.column_stack(columns) for columns in [_noisy(case)]]
    errors = errors_of(law, recorded, np.zeros(3), [0])
    at_truth = nrmse([recorded[0][:, 0]], [law.shown[0][:, 0]])
    assert errors["position"] == pytest.approx(at_truth)
    assert errors["position"] * np.ptp(recorded[0][:, 0]) < 2.0 * case.machine.quantum


def _noisy(case: Remade) -> tuple[Vector, Vector]:
    text_columns = replace(case, rng=np.random.default_rng(9)).recordings()[0]
    return text_columns[:, 0], text_columns[:, 1]


# ---- widths


def test_the_bound_of_a_straight_line_is_the_one_of_every_textbook() -> None:
    """Variance of the slope sigma^2 / sum (x - mean)^2 where the offset is unknown too."""
    x, sigma = np.linspace(0.0, 3.0, 50), 0.2
    slopes = np.column_stack([x, np.ones(50)]) / sigma
    expected = sigma / np.sqrt(np.sum((x - x.mean()) ** 2))
    assert standard_error(slopes, np.array([1.0, 0.0])) == pytest.approx(expected)
    alike = np.column_stack([x, 2.0 * x]) / sigma
    assert standard_error(alike, np.array([1.0, 0.0])) == np.inf
    # What both add to is told all the same.
    assert standard_error(alike, np.array([1.0, 2.0])) == pytest.approx(sigma / np.linalg.norm(x))


def test_white_noise_whitens_to_the_sum_of_squares() -> None:
    x = np.random.default_rng(2).standard_normal((ROWS, 1))
    flat = noise_of([np.full((ROWS // 2 + 1, 1, 1), ROWS * 0.5**2, dtype=complex)])
    white = flat.white([x])
    assert white @ white == pytest.approx(np.sum((x / 0.5) ** 2))


def test_a_stretch_of_a_difference_has_the_power_of_its_ends_at_zero() -> None:
    """Of n_k - n_(k-1) a sum over N rows is n_N - n_0: its variance is 2, whatever N is."""
    frequency = np.fft.rfftfreq(ROWS)
    s = np.abs(1.0 - np.exp(-2j * np.pi * frequency))[:, None, None] ** 2
    smeared = ROWS * of_a_stretch(s.astype(complex), ROWS)
    assert smeared[0, 0, 0].real == pytest.approx(2.0)
    assert smeared[100:, 0, 0].real == pytest.approx(ROWS * s[100:, 0, 0], rel=0.05)


@pytest.mark.parametrize("machine", ["servo", "axis", "wires_pid"])
def test_prediction_errors_are_the_noise_of_the_encoder_whatever_the_law(machine: str) -> None:
    own = MACHINES[machine]
    level = 0.02 * own.truth["u_limit"] * own.truth["torque_gain"]
    case = case_of(machine, friction_positive=level, friction_negative=level)
    noise = np.zeros(PREROLL + ROWS)
    noise[PREROLL + 100 :] = own.jitter * np.random.default_rng(4).standard_normal(ROWS - 100)
    one = case.experiments[0]
    run = simulate({**case.plant, **one.gains}, one.reference, noise)
    recorded = np.column_stack([run.reading, run.new])
    left = run.reading - driven(case.plant, recorded)
    assert left == pytest.approx(noise[PREROLL:], abs=1e-3 * own.jitter)
    command = command_of({**case.values, **one.gains}, one.reference, run.reading)
    assert command == pytest.approx(run.new, rel=1e-9, abs=1e-9)


def test_in_closed_loop_the_spectrum_of_noise_is_that_of_repeated_runs() -> None:
    case = case_of()
    noise = noise_in(case)
    squares = []
    for seed in range(6):
        own = replace(case, rng=np.random.default_rng(seed))
        left = own.recordings()[0] - case.clean(case.plant)[0]
        white = noise.white([left])
        squares.append(white @ white / white.size)
    assert np.mean(squares) == pytest.approx(1.0, abs=0.05)


def test_the_bound_of_a_scale_of_the_sensor_is_the_closed_form() -> None:
    """Its derivative is the position itself: sigma over what the unknown start leaves of it."""
    case = case_of("servo_measured", sensor_scale=0.02)
    law = law_of(case, "sensor_scale")
    bounds = narrowest(law, ["sensor_scale.share"], {})["sensor_scale.share"]
    one = case.experiments[0]
    position = simulate({**case.plant, **one.gains}, one.reference).position
    rate = case.values["viscous"] / case.values["inertia"]
    start = np.column_stack([np.ones(ROWS), np.exp(-rate * 1e-3 * np.arange(ROWS))])
    left = position - start @ np.linalg.lstsq(start, position, rcond=None)[0]
    sigma = np.hypot(case.machine.jitter, case.machine.quantum / np.sqrt(12.0))
    expected = 2.0 * 1.959964 * sigma / np.linalg.norm(left)
    assert bounds.width_without == pytest.approx(expected, rel=1e-3)
    assert bounds.width > bounds.width_without


# ---- sets


def separation_of(case: Remade, law: str, changes: Changes) -> Separation:
    """A case that hides one law."""
    effect = {"name": law, "changes": changes, "added_gain": 1e9, "windows": []}
    return Separation(case, {"effects": [effect]})


@pytest.mark.parametrize(
    ("law", "rival", "changes"),
    [
        ("actuator_lag", "sensor_lag", {"drive_lag": 1e-3}),
        ("sensor_scale", "actuator_gain_loss", {"sensor_scale": 0.05}),
    ],
)
def test_no_oracle_tells_laws_that_commute_round_a_linear_loop(
    law: str, rival: str, changes: Changes
) -> None:
    case = case_of("servo_measured", **changes)
    assert separation_of(case, law, changes).gain(law, rival) < 1e-3


def test_an_oracle_tells_soft_friction_from_hard() -> None:
    changes = {"bristle_level": 0.3, "bristle_stiffness": 15.0, "bristle_damping": 0.02}
    case = case_of("servo", **changes)
    assert (
        separation_of(case, "presliding_friction", changes).gain(
            "presliding_friction", "coulomb_friction"
        )
        > 60.0
    )


def test_over_a_plant_without_the_law_the_gain_is_that_by_which_it_is_owed() -> None:
    changes = {"drag": 2e-3}
    case = case_of("servo", **changes)
    free = coordinates(
        {name: case.values[name] for name in case.machine.free}, (), case.machine.free
    )
    found, _ = case.oracle.gain_over(case.oracle.means(changes), free.at, 2)
    assert found == pytest.approx(case.oracle.gain(changes), rel=1e-6)


def outcome(*names: str, hidden: str, rivals: tuple[str, ...] = ()) -> dict[str, Any]:
    """A line of the runner."""
    return {
        "case": "000",
        "seconds": 1.0,
        "note": "",
        "answer": answer(hidden),
        "diagnosis": said(*names, rivals=rivals),
    }


def test_what_stood_in_a_set_once_is_a_rival_of_what_is_told_alone() -> None:
    as_set = judge(outcome("actuator_lag", hidden="sensor_lag", rivals=("sensor_lag",)))
    alone = judge(outcome("sensor_lag", hidden="sensor_lag"))
    same = judge(
        outcome("viscous_friction", hidden="viscous_friction", rivals=("parameter:viscous",))
    )
    partners = partners_of([as_set, alone, same])
    (told,) = statements_of(as_set, partners)
    assert (told.law, told.told, told.rivals) == (
        "sensor_lag",
        frozenset({"actuator_lag"}),
        frozenset({"actuator_lag"}),
    )
    (single,) = statements_of(alone, partners)
    assert (single.told, single.rivals) == (frozenset(), frozenset({"actuator_lag"}))
    (equivalent,) = statements_of(same, partners)  # a parameter and its law are one statement
    assert (equivalent.told, equivalent.rivals) == (frozenset(), frozenset())


def test_a_law_is_separated_that_gains_over_every_rival() -> None:
    assert separated({"gains": {"a": 61.0, "b": 1e4}})
    assert not separated({"gains": {"a": 59.0, "b": 1e4}})
    assert not separated({"gains": {}})
    assert separated({"gains": {"a": None}})  # no such plant can be run


# ---- table


def test_the_interval_of_a_median_is_the_published_one() -> None:
    """Of 25 values the 8th and the 18th (Conover 1999, table A3)."""
    values = [float(k) for k in range(1, 26)]
    assert quantile_interval(values, 0.5) == (8.0, 18.0)
    assert quantile_interval(values[:5], 0.5) == (-np.inf, np.inf)


def test_the_table_counts_what_was_compared() -> None:
    held = {"ratio": 2.0, "named": True, "true": {"position": 0.1}, "noise": {"position": 0.1}}
    width = {"name": "a.b", "kind": "law", "width": 3.0, "narrowest": 2.0, "holds": True}
    line = {
        "case": "000",
        "stratum": "owed",
        "machine": "servo",
        "hidden": ["actuator_lag"],
        "outcome": "right",
        "held_out": held,
        "statements": [
            {"law": "actuator_lag", "told": ["sensor_lag"], "gains": {"sensor_lag": 70.0}},
            {"law": "actuator_lag", "told": [], "gains": {"sensor_lag": 70.0}},
        ],
        "intervals": [{**width, "narrowest_without": 1.0, "by_frequency": None}],
    }
    one = outcome("actuator_lag", hidden="actuator_lag")
    errors = {"parameters_only": 0.5, "augmented": 0.2, "free_run": None}
    one["diagnosis"]["fit"] = {"signals": {"position": errors}}
    text = table([line], [one])
    assert "5 [-inf, inf]" in text  # the refitted twin
    assert "0 of 1 owed ones not yet" in text
    assert "sets among the separated          1 of 2" in text
    assert "2 [-inf, inf]" in text
    assert "1.5 [-inf, inf]" in text
