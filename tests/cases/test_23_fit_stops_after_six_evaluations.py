"""A fit that needs more than six evaluations goes on until chi2 no longer falls."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "23-fit-stops-after-six-evaluations"
COMMAND = "diagnose twin.toml cnull*.csv --out f"
TRUTH = {"gain": 0.6, "tau": 700.0, "dead_time": 120.0}
pytestmark = [needs_case(CASE), pytest.mark.slow]


def test_the_values_of_the_recorded_plant_are_found(case: CaseFolder) -> None:
    answer = case.gmfbo(COMMAND)
    assert answer.code == 0
    found = case.json("f/diagnosis.json")
    assert found["verdict"] == "parameters"
    assert found["converged"] is True
    for name, value in TRUTH.items():
        assert found["parameters"][name]["value"] == pytest.approx(value, rel=1e-3)
    tau = found["parameters"]["tau"]
    assert tau["low"] <= TRUTH["tau"] <= tau["high"]
    assert found["cost"]["simulations"] <= 400
