"""A compared output whose column has another name is told first, with that name."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "02-output-missing-in-silence"
pytestmark = needs_case(CASE)
NEAREST = {
    "capital_Position.csv": "no column position; did you mean 'Position'?",
    "dup_two_rates.mf4": "no column position; did you mean 'group 0/position'?",
}


@pytest.mark.parametrize("recording", NEAREST)
def test_check_tells_it_first(recording: str, case: CaseFolder) -> None:
    answer = case.gmfbo(f"check ../servo.toml {recording}")
    assert answer.code == 0
    assert answer.out.startswith(
        f"servo axis: 1 recording, 1 thing to look at ! {recording}, position: {NEAREST[recording]}"
    )


@pytest.mark.parametrize("recording", NEAREST)
def test_simulate_tells_it_before_any_error(recording: str, case: CaseFolder) -> None:
    answer = case.gmfbo(f"simulate ../servo.toml --reference {recording} --out s.csv")
    assert answer.code == 0
    told = f"! {recording}: {NEAREST[recording]}; position is not compared"
    assert told in answer.out
    assert answer.out.index(told) < answer.out.index("NRMSE")


def test_diagnose_calls_nothing_right_that_was_not_compared(case: CaseFolder) -> None:
    answer = case.gmfbo("diagnose ../servo.toml capital_Position.csv --out d")
    assert answer.code == 0
    assert answer.out.startswith(
        "Not compared: position (capital_Position.csv: no column position; did you mean "
        "'Position'?). In what was compared, nothing is missing"
    )
    told = case.json("d/diagnosis.json")["not_compared"]
    assert told == ["position (capital_Position.csv: no column position; did you mean 'Position'?)"]
