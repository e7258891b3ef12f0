"""Recordings without a clock: the time between two rows is stated."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "17-no-clock"
pytestmark = needs_case(CASE)
FILES = {"no_time.csv": 200, "plain.tdms": 1000}


@pytest.mark.parametrize(("name", "rows"), FILES.items(), ids=FILES.keys())
def test_no_clock_is_shown_and_the_way_to_state_one_is_told(
    case: CaseFolder, name: str, rows: int
) -> None:
    answer = case.gmfbo(f"columns ../servo.toml {name}")
    assert answer.code == 0, answer.err
    assert f"3 columns, {rows} rows" in answer.out
    assert (
        "not found: the clock; say where with --set 'time=COLUMN [ms]', or, if there" in answer.out
    )
    assert "--sample-time 0.001" in answer.out


@pytest.mark.parametrize(("name", "rows"), FILES.items(), ids=FILES.keys())
def test_with_a_sample_time_it_is_compared(case: CaseFolder, name: str, rows: int) -> None:
    told = case.gmfbo(f"columns ../servo.toml {name} --sample-time 1e-3 --save m.toml")
    assert told.code == 0, told.err
    twin = case.path / "twin.toml"
    text = (case.path / "../servo.toml").read_text(encoding="utf-8")
    twin.write_text('columns = "m.toml"\n' + text, encoding="utf-8")
    answer = case.gmfbo(f"simulate twin.toml --reference {name} --out s.csv")
    assert answer.code == 0, answer.err
    assert f"{rows} rows, {(rows - 1) / 1000:g} s" in answer.out
    nrmse = [float(word) for word in answer.out.split() if word.replace(".", "").isdigit()]
    assert nrmse[-1] < 1.0


def test_a_sample_time_that_is_none_is_refused(case: CaseFolder) -> None:
    answer = case.gmfbo("columns ../servo.toml no_time.csv --sample-time 0")
    assert answer.code == 2
    assert "--sample-time: expected seconds above 0, got 0" in answer.err
