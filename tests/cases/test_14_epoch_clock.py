"""An FMU that looks at its time answers alike, whatever clock the logger has."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "14-epoch-clock-starts-the-fmu"
pytestmark = needs_case(CASE)


@pytest.mark.parametrize("recording", ["timer_zero.csv", "timer_dated.csv", "timer_epoch.csv"])
def test_the_step_comes_half_a_second_after_the_first_row(recording: str, case: CaseFolder) -> None:
    answer = case.gmfbo(f"simulate timer.toml --reference {recording} --out s.csv")
    assert answer.code == 0
    assert answer.out.endswith("y 0 %")


def test_control_the_recorded_time_is_handed_over_where_it_is_asked_for(case: CaseFolder) -> None:
    file = case.path / "timer.toml"
    file.write_text(file.read_text() + '\n[recording]\nclock = "fmu"\n')
    answer = case.gmfbo("simulate timer.toml --reference timer_epoch.csv --out s.csv")
    assert answer.out.endswith("y 70.71 %")
