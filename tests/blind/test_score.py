"""Scoring of diagnoses, on hand-made answers and diagnoses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.blind.bars import clopper_pearson
from tests.blind.limits import gain_at, logistic
from tests.blind.probabilities import brier_scores, events_of
from tests.blind.score import Scored, overlaps, score_case
from tests.blind.tables import report


def answer(*names: str, kind: str = "single", **changes: Any) -> dict[str, Any]:
    """Answer of a case with these hidden effects, all at reversals in rec0.csv."""
    effects = [
        {
            "name": name,
            "signal_path": ["plant"],
            "states": ["velocity"],
            "windows": [["rec0.csv", 1.0, 1.1]],
        }
        for name in names
    ]
    return {
        "case": "000",
        "kind": kind,
        "machine": "servo",
        "effects": effects,
        "oracle_gain": 100.0 if names else 0.0,
        "within_reach": True,
        "nearest": [],
        "parameters": {"inertia": {"true": 0.01, "nominal": 0.011}},
    } | changes


def diagnosis(*names: str, rivals: tuple[str, ...] = (), **changes: Any) -> dict[str, Any]:
    """A diagnosis that names these effects at a reversal."""
    return {
        "verdict": "missing_physics" if names else "parameters",
        "effects": [
            {"name": name, "probability": 0.9, "indistinguishable_from": list(rivals)}
            for name in names
        ],
        "location": {
            "signal_path": "plant",
            "region": "where the velocity changes sign",
            "times": [["rec0.csv", 1.05, 1.2]],
        },
        "parameters": {"inertia": {"value": 0.0101}},
        "fit": {"explainable_error_removed": 0.9},
        "cost": {"simulations": 600, "seconds": 9.0},
    } | changes


def test_the_hidden_effect_by_its_name_is_right() -> None:
    scored = score_case(answer("cogging_torque"), diagnosis("cogging_torque"), 10.0)
    assert scored.outcome == "right"
    assert scored.path_right is True
    assert scored.place_right is True
    assert scored.claims == ((0.9, True),)
    assert dict(scored.numbers.twin_errors) == pytest.approx({"inertia": 0.01})
    assert dict(scored.numbers.twin_covered) == {"inertia": False}
    assert scored.simulations == 600


@pytest.mark.parametrize(
    ("hidden", "named", "rivals", "outcome"),
    [
        ("coulomb_friction", "stribeck_friction", (), "right"),  # one family
        ("coulomb_friction", "viscous_friction", (), "wrong"),
        ("coulomb_friction", "quadratic_drag", (), "wrong"),
        ("gravity_torque", "elastic_return", ("gravity_torque",), "set"),
        ("gravity_torque", "elastic_return", ("coulomb_friction",), "wrong"),
        ("presliding_friction", "hysteresis", ("coulomb_friction",), "set"),
    ],
)
def test_another_name_counts_by_family_and_by_its_rivals(
    hidden: str, named: str, rivals: tuple[str, ...], outcome: str
) -> None:
    assert score_case(answer(hidden), diagnosis(named, rivals=rivals), 1.0).outcome == outcome


def test_nothing_named_is_a_miss_where_something_is_hidden_and_right_elsewhere() -> None:
    assert score_case(answer("backlash"), diagnosis(), 1.0).outcome == "missed"
    for kind in ("null", "stressed_null", "decoy"):
        assert score_case(answer(kind=kind), diagnosis(), 1.0).outcome == "right"
        assert score_case(answer(kind=kind), diagnosis("backlash"), 1.0).outcome == "wrong"


def test_a_second_name_that_is_not_hidden_is_wrong() -> None:
    named = diagnosis("cogging_torque", "quadratic_drag")
    assert score_case(answer("cogging_torque"), named, 1.0).outcome == "wrong"


def test_a_second_law_of_the_same_family_is_not_the_whole_answer() -> None:
    named = diagnosis("coulomb_friction", "presliding_friction")
    assert score_case(answer("coulomb_friction"), named, 1.0).outcome == "partial"


def test_of_a_pair_one_name_is_part_of_the_answer() -> None:
    hidden = answer("cogging_torque", "coulomb_friction", kind="pair")
    assert score_case(hidden, diagnosis("coulomb_friction"), 1.0).outcome == "partial"
    both = diagnosis("asymmetric_friction", "cogging_torque")
    assert score_case(hidden, both, 1.0).outcome == "right"


def test_without_the_port_every_name_is_wrong() -> None:
    hidden = answer("coulomb_friction", within_reach=False)
    assert score_case(hidden, diagnosis(), 1.0).outcome == "right"
    assert score_case(hidden, diagnosis("coulomb_friction"), 1.0).outcome == "wrong"


def test_outside_the_catalogue_the_verdict_counts() -> None:
    hidden = answer("root_friction", kind="outside", nearest=["coulomb_friction"])
    flagged = diagnosis(verdict="outside_library")
    assert score_case(hidden, flagged, 1.0).outcome == "right"
    assert score_case(hidden, diagnosis("coulomb_friction"), 1.0).outcome == "nearest"
    both = diagnosis("coulomb_friction", verdict="outside_library")
    assert score_case(hidden, both, 1.0).outcome == "right"
    assert score_case(hidden, diagnosis("backlash"), 1.0).outcome == "wrong"
    assert score_case(hidden, diagnosis(), 1.0).outcome == "missed"


@pytest.mark.parametrize(
    ("location", "path", "place"),
    [
        ({"signal_path": "actuator"}, False, False),
        ({"signal_path": "plant", "region": "where the command is large"}, True, False),
        ({"signal_path": "plant", "region": "where the velocity changes sign"}, True, False),
        (
            {
                "signal_path": "plant",
                "region": "at low speed",
                "times": [["cases/000/rec0.csv", 0.9, 1.0], ["rec1.csv", 1.0, 1.1]],
            },
            True,
            True,
        ),
        (
            {
                "signal_path": "plant",
                "region": "at low speed",
                "times": [["rec0.csv", 0.9, 0.99], ["rec1.csv", 1.0, 1.1]],
            },
            True,
            False,
        ),
    ],
)
def test_a_place_is_a_path_a_state_and_times(
    location: dict[str, Any], path: bool, place: bool
) -> None:
    scored = score_case(
        answer("coulomb_friction"), diagnosis("coulomb_friction", location=location), 1.0
    )
    assert (scored.path_right, scored.place_right) == (path, place)


def test_windows_that_say_everything_do_not_hide_that_most_of_them_are_wrong() -> None:
    true = [["rec0.csv", 1.0, 1.1]]
    assert overlaps([["rec0.csv", 0.0, 3.0]], true)
    assert not overlaps([["rec0.csv", 1.0, 1.1], *[["rec0.csv", 2.0, 2.1]] * 2], true)
    assert not overlaps([], true)


def test_the_exact_interval_is_the_published_one() -> None:
    """0 of 150 is at most 2.4 %; 1 of 10 is 0.25 to 44.5 % (Clopper, Pearson 1934)."""
    assert clopper_pearson(0, 150) == pytest.approx((0.0, 0.0243), abs=1e-4)
    assert clopper_pearson(1, 10) == pytest.approx((0.00253, 0.445), abs=1e-3)
    assert clopper_pearson(3, 3)[1] == 1.0
    assert clopper_pearson(0, 0) == (0.0, 1.0)


def test_the_report_counts_bars_and_lists_every_failure() -> None:
    scores = [
        score_case(answer("cogging_torque"), diagnosis("cogging_torque"), 10.0),
        score_case(answer("backlash", case="001"), diagnosis("hysteresis"), 20.0),
        score_case(answer(kind="null", case="002"), diagnosis(), 5.0),
        score_case(answer(kind="stressed_null", case="003"), diagnosis("sensor_lag"), 5.0),
        score_case(answer("sensor_lag", case="004", oracle_gain=9.0), diagnosis(), 5.0),
        score_case(answer("sensor_lag", case="005"), None, 300.0, "more than 300 s"),
    ]
    text = report(scores, {"cases": 6, "seed": 1})
    bars = {line[:34].strip(): line[34:].split() for line in text.splitlines() if "[" in line}
    assert bars["gain > 60: named right"][:3] == ["1", "of", "3"]
    assert bars["gain < 15: something named"][:3] == ["0", "of", "1"]
    assert bars["nulls with a claim"][:3] == ["1", "of", "2"]
    assert bars["wrong names, all cases"][:3] == ["2", "of", "6"]
    assert bars["failed runs"][:3] == ["1", "of", "6"]
    failures = text[text.index("Not as it should be") :].splitlines()[1:]
    assert [line[:3] for line in failures] == ["001", "005", "003"]
    assert "more than 300 s" in failures[1]


def test_a_run_that_failed_is_no_claim() -> None:
    scored = score_case(answer(kind="null"), None, 300.0, "more than 300 s")
    assert isinstance(scored, Scored)
    assert scored.outcome == "failed"
    assert scored.named == ()


def test_numbers_are_judged_where_the_law_is_the_hidden_one() -> None:
    """A wave's sine and cosine count as one size; each interval counts by itself."""
    hidden = answer("cogging_torque")
    hidden["effects"][0]["values"] = {"sine_1": 3.0, "cosine_1": -4.0, "wavenumber_1": 7.0}
    said = diagnosis("cogging_torque")
    said["effects"][0]["parameters"] = {
        "sine_1": {"value": 3.3, "low": 2.9, "high": 3.4},
        "cosine_1": {"value": -4.4, "low": -4.6, "high": -4.2},
        "wavenumber_1": {"value": 7.07, "low": 6.9, "high": 7.1},
    }
    numbers = score_case(hidden, said, 1.0).numbers
    assert dict(numbers.errors) == pytest.approx(
        {"cogging_torque.amplitude_1": 0.1, "cogging_torque.wavenumber_1": 0.01}
    )
    assert [held for _, held in numbers.covered] == [True, False, True]
    assert score_case(answer("coulomb_friction"), said, 1.0).numbers.errors == ()


def test_held_out_errors_are_told_in_noise_floors() -> None:
    models = {"nominal": 8.0, "parameters_only": 4.0, "unnamed_spline": 3.0, "augmented": 1.0}
    signals = {"a": {**models, "noise_floor": 1.0}, "b": {**models, "noise_floor": 0.5}}
    fit = {"explainable_error_removed": 0.9, "signals": signals}
    held = dict(score_case(answer(), diagnosis(fit=fit), 1.0).numbers.held_out)
    assert held["nominal"] == pytest.approx(8.0 * np.sqrt(2.5))
    assert held["augmented"] == pytest.approx(np.sqrt(2.5))


def test_what_a_motion_in_one_direction_hides_may_be_named_but_nothing_else() -> None:
    hidden = answer("coulomb_friction", kind="decoy")
    assert score_case(hidden, diagnosis(), 1.0).outcome == "right"
    assert score_case(hidden, diagnosis("coulomb_friction"), 1.0).outcome == "right"
    assert score_case(hidden, diagnosis("constant_torque_offset"), 1.0).outcome == "wrong"


def test_a_pair_is_as_strong_as_what_its_weaker_effect_adds() -> None:
    hidden = answer("cogging_torque", "coulomb_friction", kind="pair", oracle_gain=900.0)
    for effect, gain in zip(hidden["effects"], (800.0, 40.0), strict=True):
        effect["added_gain"] = gain
    scored = score_case(hidden, diagnosis("cogging_torque"), 1.0)
    assert scored.gain == 40.0
    assert not scored.is_owed


def test_any_name_without_the_verdict_is_false_outside_the_catalogue() -> None:
    hidden = answer("root_friction", kind="outside", nearest=["coulomb_friction"])
    assert score_case(hidden, diagnosis("coulomb_friction"), 1.0).has_false_name
    flagged = diagnosis("coulomb_friction", verdict="outside_library")
    assert not score_case(hidden, flagged, 1.0).has_false_name
    assert not score_case(hidden, diagnosis(verdict="parameters"), 1.0).has_false_name
    other = diagnosis("backlash", verdict="outside_library")
    assert score_case(hidden, other, 1.0).has_false_name


def test_the_brier_score_counts_claims_and_abstentions() -> None:
    """Two claims of 0.9, one right; an owed name missed; a null left alone: four events."""
    scores = [
        score_case(answer("cogging_torque"), diagnosis("cogging_torque"), 1.0),
        score_case(answer("backlash"), diagnosis("hysteresis"), 1.0),
        score_case(answer("sensor_lag"), diagnosis(), 1.0),
        score_case(answer(kind="null"), diagnosis(), 1.0),
    ]
    stated, always, true = events_of(scores)
    assert stated == [0.9, 0.9, 0.0, 0.0]
    assert always == [0.95, 0.95, 0.0, 0.0]
    assert true == [True, False, True, False]
    lines = brier_scores(scores).splitlines()
    assert float(lines[1].split()[-1]) == pytest.approx((0.01 + 0.81 + 1.0) / 4.0, abs=1e-4)
    assert float(lines[3].split()[-1]) == pytest.approx(0.25, abs=1e-4)


def test_the_logistic_curve_finds_where_names_begin() -> None:
    """Names drawn by known odds: half at a gain of 30, the fit within its sampling error."""
    rng = np.random.default_rng(3)
    gains = 10.0 ** rng.uniform(0.0, 4.0, 4000)
    named = rng.random(4000) < 1.0 / (1.0 + (30.0 / gains) ** 2)
    curve = logistic(gains.tolist(), named.tolist())
    assert gain_at(0.5, curve) == pytest.approx(30.0, rel=0.15)
    assert gain_at(0.9, curve) == pytest.approx(30.0 * 3.0, rel=0.15)
    assert gain_at(0.9, (1.0, -1.0)) == float("inf")
