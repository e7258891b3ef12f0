"""Another axis than the twin's: its values lie beyond the ranges that the twin file gives."""

from __future__ import annotations

import pytest

from gmfbo import models_folder
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "29-range-too-narrow"
COMMAND = f"diagnose {models_folder() / 'servo_axis.toml'} r*.csv --out f"
TRUTH = {"inertia": 0.055, "viscous": 0.3}
pytestmark = [needs_case(CASE), pytest.mark.slow]


def test_the_ranges_are_told_before_any_physics(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND)
    assert answer.code == 0
    assert answer.out.startswith("inertia and viscous are at the ends of their ranges.")
    assert "(servo_axis.toml, line 21)" in answer.out
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    assert found["effects"] == []
    for name, value in TRUTH.items():
        one = found["parameters"][name]
        assert one["at_bound"] == "high"
        assert one["low"] <= value <= one["high"]
    assert found["cost"]["simulations"] <= 1500


def test_control_with_wide_ranges_none_is_at_an_end(case: CaseFolder) -> None:
    answer = case.gmfbo("diagnose wide.toml r*.csv --out f")
    assert answer.code == 0
    assert "range" not in answer.out
    for name, value in TRUTH.items():
        one = case.json("f/diagnosis.json")["parameters"][name]
        assert one["at_bound"] is None
        assert one["low"] <= value <= one["high"]
