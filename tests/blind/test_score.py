"""Scoring of diagnoses, on hand-made answers and diagnoses."""

from __future__ import annotations

from typing import Any

import pytest

from tests.blind.score import Scored, overlaps, score_case
from tests.blind.tables import clopper_pearson, report


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
    assert scored.inertia_error == pytest.approx(0.01)
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
    assert [line[:3] for line in failures] == ["001", "003", "005"]
    assert "more than 300 s" in failures[-1]


def test_a_run_that_failed_is_no_claim() -> None:
    scored = score_case(answer(kind="null"), None, 300.0, "more than 300 s")
    assert isinstance(scored, Scored)
    assert scored.outcome == "failed"
    assert scored.named == ()
