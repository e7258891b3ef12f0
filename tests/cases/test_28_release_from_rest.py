"""A mass let go from three places: no force acts, so mass, stiffness and damping are ratios."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "28-release-from-rest"
COMMAND = "diagnose twin.toml v0.csv v1.csv v2.csv --out f"
TRUTH = {"mass / damping": 5.0 / 14.0, "stiffness / damping": 420.0 / 14.0}
pytestmark = needs_case(CASE)


def test_the_ratios_are_told_and_no_value_alone(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND)
    assert answer.code == 0
    assert "of mass, stiffness and damping these recordings tell only mass / damping" in answer.out
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    assert not any(one["identifiable"] for one in found["parameters"].values())
    for one in found["combinations"]:
        assert one["low"] <= TRUTH[one["expression"]] <= one["high"]
        assert one["value"] == pytest.approx(TRUTH[one["expression"]], rel=5e-3)
    assert {one["expression"] for one in found["combinations"]} == set(TRUTH)
    fit = found["fit"]
    assert {*fit["fitted_on"], *fit["held_out"]} == {"v0.csv", "v1.csv", "v2.csv"}
    position = fit["signals"]["position"]
    assert position["parameters_only"] < 1.2 * position["noise_floor"]


def test_a_start_that_nobody_recorded_is_fitted_to_each_recording(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND.replace("twin.toml", "twin_fit.toml"))
    assert answer.code == 0
    assert "x0 was fitted to each recording: 0.1 m (v0.csv)" in " ".join(answer.out.split())
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    for one in found["combinations"]:
        assert one["low"] <= TRUTH[one["expression"]] <= one["high"]
    position = found["fit"]["signals"]["position"]
    assert position["parameters_only"] < 1.2 * position["noise_floor"]


def test_one_uncertain_start_for_all_is_refused_with_what_to_write(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND.replace("twin.toml", "twin_unc.toml"))
    assert answer.code == 2
    assert 'state the start in [initial]: a recorded signal, a number, or "fit"' in " ".join(
        answer.err.split()
    )
