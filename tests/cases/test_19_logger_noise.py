"""Noise of the logger, which the controller never read, on a twin that lacks nothing."""

from __future__ import annotations

import pytest

from gmfbo import models_folder
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "19-logger-noise"
COMMAND = f"diagnose {models_folder() / 'servo_axis.toml'} null*.csv --out f"
pytestmark = needs_case(CASE)


@pytest.mark.slow
def test_the_inertia_is_told_and_nothing_is_missing(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND)
    assert answer.code == 0
    assert "no physics is missing" in answer.out
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    assert found["effects"] == []
    assert not any(one["fixed"] for one in found["parameters"].values())
    inertia = found["parameters"]["inertia"]
    assert inertia["low"] <= 0.0105 <= inertia["high"]
