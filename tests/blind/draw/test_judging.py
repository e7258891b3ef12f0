"""Judging of what was said, on hand-made answers and diagnoses."""

from __future__ import annotations

from typing import Any

import pytest

from tests.blind.draw.equivalents import same_statement, statements_of_parameter
from tests.blind.draw.judging import judge
from tests.blind.draw.methods import methods
from tests.blind.draw.table import table


def answer(
    *names: str, stratum: str = "owed", fixed: str = "", gain: float = 100.0, **changes: Any
) -> dict[str, Any]:
    """Answer of a drawn case with these hidden effects."""
    kind = {"owed": "single"}.get(stratum, stratum)
    details: dict[str, Any] = {"stratum": stratum, "family": "", "variant": "", "size": "above"}
    if stratum == "null":
        details |= {"family": "fixed" if fixed else "logger", "size": ""}
    if fixed:
        details["fixed"] = {"name": fixed, "true": 2e-3, "believed": 1e-3}
    effects = [{"name": name, "values": {"level": 0.2}, "added_gain": gain} for name in names]
    return {
        "case": "000",
        "kind": kind,
        "machine": "servo",
        "effects": effects,
        "oracle_gain": gain if names else 0.0,
        "nearest": [],
        "parameters": {"inertia": {"true": 0.01, "nominal": 0.011}},
        "details": details,
    } | changes


def said(
    *names: str,
    rivals: tuple[str, ...] = (),
    verdict: str = "",
    parameters: dict[str, Any] | None = None,
    probability: float | None = 0.9,
) -> dict[str, Any]:
    """A diagnosis that names these effects."""
    return {
        "verdict": verdict or ("missing_physics" if names else "parameters"),
        "effects": [
            {
                "name": name,
                "probability": probability,
                "indistinguishable_from": list(rivals),
                "parameters": {"level": {"value": 0.2, "low": 0.19, "high": 0.22}},
            }
            for name in names
        ],
        "parameters": {"inertia": {"nominal": 0.011, "value": 0.01, "low": 0.0099, "high": 0.0102}}
        | (parameters or {}),
        "cost": {"simulations": 100},
    }


def outcome(hidden: dict[str, Any], diagnosis: dict[str, Any] | None) -> str:
    return judge(line(hidden, diagnosis)).outcome


def line(hidden: dict[str, Any], diagnosis: dict[str, Any] | None) -> dict[str, Any]:
    note = "" if diagnosis else "more than 300 s"
    return {
        "case": "000",
        "seconds": 10.0,
        "note": note,
        "answer": hidden,
        "diagnosis": diagnosis,
    }


FREED = {"nominal": 1e-3, "value": 1.9e-3, "low": 1.8e-3, "high": 2.1e-3, "fixed": True}


@pytest.mark.parametrize(
    ("diagnosis", "expected"),
    [
        (said(), "right"),
        (said(verdict="none"), "right"),
        (said("coulomb_friction"), "named"),
        (said(verdict="outside_library"), "outside"),
        (said("coulomb_friction", verdict="outside_library"), "named"),
        (said(parameters={"filter_time": FREED}), "named"),
        (said(parameters={"filter_time": FREED | {"value": 1e-3}}), "right"),
        (None, "failed"),
    ],
)
def test_in_a_null_only_silence_is_right(diagnosis: dict[str, Any] | None, expected: str) -> None:
    assert outcome(answer(stratum="null"), diagnosis) == expected


@pytest.mark.parametrize(
    ("diagnosis", "expected"),
    [
        (said(), "right"),
        (said(parameters={"torque_lag": FREED}), "told"),
        (said("actuator_lag"), "told"),
        (said("transport_delay", rivals=("parameter:torque_lag",)), "told"),
        (said("transport_delay"), "named"),
        (said(parameters={"filter_time": FREED}), "named"),
        (said(verdict="outside_library"), "outside"),
    ],
)
def test_a_wrong_fixed_parameter_is_told_as_such_or_as_nothing(
    diagnosis: dict[str, Any], expected: str
) -> None:
    assert outcome(answer(stratum="null", fixed="torque_lag"), diagnosis) == expected


@pytest.mark.parametrize(
    ("diagnosis", "expected"),
    [
        (said("backlash"), "right"),
        (said("torsional_compliance", rivals=("backlash",)), "set"),
        (said("torsional_compliance"), "wrong"),
        (said("backlash", "cogging_torque"), "wrong"),
        (said(), "missed"),
        (said(verdict="outside_library"), "missed"),
        (said("backlash", verdict="outside_library"), "partial"),
        (None, "failed"),
    ],
)
def test_an_owed_name_is_right_an_honest_set_or_neither(
    diagnosis: dict[str, Any] | None, expected: str
) -> None:
    assert outcome(answer("backlash"), diagnosis) == expected


def test_a_lag_that_the_twin_has_is_the_law_of_the_lag() -> None:
    assert outcome(answer("actuator_lag"), said(parameters={"torque_lag": FREED})) == "right"
    assert outcome(answer("actuator_lag"), said(parameters={"filter_time": FREED})) == "wrong"


def test_of_a_pair_both_are_asked_for() -> None:
    pair = answer("coulomb_friction", "cogging_torque", stratum="pair")
    assert outcome(pair, said("coulomb_friction", "cogging_torque")) == "right"
    assert outcome(pair, said("coulomb_friction")) == "partial"
    assert outcome(pair, said("coulomb_friction", "coulomb_friction")) == "partial"
    assert outcome(pair, said("coulomb_friction", "backlash")) == "wrong"


def test_outside_the_library_the_verdict_is_asked_for() -> None:
    hidden = answer("cubic_drag", stratum="outside", nearest=["quadratic_drag"])
    assert outcome(hidden, said(verdict="outside_library")) == "right"
    assert outcome(hidden, said("quadratic_drag", verdict="outside_library")) == "right"
    assert outcome(hidden, said("quadratic_drag")) == "nearest"
    assert outcome(hidden, said("backlash", verdict="outside_library")) == "wrong"
    assert outcome(hidden, said()) == "missed"


def test_intervals_are_held_against_the_truth_where_the_physics_is_right() -> None:
    judged = judge(line(answer("coulomb_friction"), said("coulomb_friction")))
    held = {interval.name: interval.holds for interval in judged.intervals}
    assert held == {"coulomb_friction.level": True, "inertia": True}
    widths = {interval.name: interval.width for interval in judged.intervals}
    assert widths["coulomb_friction.level"] == pytest.approx(0.015 / 0.2)
    missed = judge(line(answer("coulomb_friction"), said()))
    assert missed.intervals == ()


def test_a_twins_inertia_is_that_of_motor_and_load() -> None:
    hidden = answer("backlash")
    hidden["effects"][0]["values"] = {"load_inertia": 0.004}
    hidden["parameters"]["inertia"]["true"] = 0.006
    (held,) = judge(line(hidden, said("backlash"))).intervals
    assert (held.name, held.holds) == ("inertia", True)


def test_a_silent_answer_to_a_wrong_fixed_parameter_owes_no_interval() -> None:
    null = answer(stratum="null", fixed="torque_lag")
    assert judge(line(null, said())).intervals == ()
    told = judge(line(null, said(parameters={"torque_lag": FREED})))
    assert {i.name: i.holds for i in told.intervals} == {"inertia": True, "torque_lag": True}


def test_a_parameter_without_an_equal_law_stands_for_itself() -> None:
    assert same_statement("parameter:controller.filter_time") == "parameter:controller.filter_time"
    assert same_statement("parameter:plant.torque_constant") == "actuator_gain_loss"
    assert statements_of_parameter("mass") == {"parameter:mass", "load_inertia"}


def test_the_table_counts_each_stratum() -> None:
    lines = [
        line(answer(stratum="null"), said()),
        line(answer(stratum="null"), said("backlash")),
        line(answer("backlash"), said("backlash")),
        line(answer("backlash", gain=20.0), said()),
        line(answer("backlash"), None),
    ]
    text = table([judge(one) for one in lines])
    assert "5 cases run: 2 null, 3 owed" in text
    assert "all              2        1        0        1        0        0   1 of 2" in text
    assert "owed, right                       1 of 2" in text  # the third is below what is owed
    assert "more than 300 s" in text
    assert f"{'seconds, wall clock':<34}median 10, 90 % 10, most 10" in text
    assert "all processes" not in text  # these lines did not count them


def test_methods_are_counted_on_the_cases_that_all_of_them_ran() -> None:
    owed = answer("backlash")
    told = [
        judge(line(owed, said("backlash"))),
        judge(line(answer(stratum="null"), said("coulomb_friction")) | {"case": "001"}),
    ]
    silent = [judge(line(owed, said()))]
    first, second = methods({"loud": told, "silent": silent}).splitlines()[2:]
    assert first.split()[:10] == ["loud", *["0", "of", "0", "1", "of", "1", "1", "of", "1"]]
    assert second.split()[:10] == ["silent", *["0", "of", "0", "0", "of", "1", "0", "of", "1"]]


def test_a_pair_is_as_strong_as_what_its_weaker_effect_adds() -> None:
    hidden = answer("cogging_torque", "coulomb_friction", stratum="pair", oracle_gain=900.0)
    assert judge(line(hidden, said("cogging_torque"))).is_owed
    hidden["effects"][1]["added_gain"] = 40.0
    assert not judge(line(hidden, said("cogging_torque"))).is_owed
