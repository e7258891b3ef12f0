"""Gains that take single values: refused where there is none, ended where all were run."""

from __future__ import annotations

import pytest

from gmfbo import Study
from tests.cases.case_folder import CaseFolder, needs_case

CASE = "26-integer-gains"
pytestmark = [needs_case(CASE), pytest.mark.slow]


def test_an_integer_range_without_an_integer_is_refused(case: CaseFolder) -> None:
    answer = case.gmfbo("tune intnone.toml")
    assert answer.code == 2
    assert "holds a whole number, got [100.2, 100.8]" in answer.err
    assert not (case.path / "intnone.study").exists()


def test_an_exhausted_grid_ends_with_its_result(case: CaseFolder) -> None:
    for command in ("tune bo_ei.toml", "tune bo_ei.toml --resume"):
        answer = case.gmfbo(command)
        assert answer.code == 0, answer.err
        assert "9 real runs" in answer.out
        assert "recommended" in answer.out


@pytest.mark.parametrize("method", ["bo_ei", "random", "gmfbo_paper"])
def test_listed_values_are_run_once_each_and_no_others(case: CaseFolder, method: str) -> None:
    text = (case.path / "bo_ei.toml").read_text(encoding="utf-8").replace("bo_ei", method)
    for name in ("ctl.Kp", "ctl.Kd"):
        line = next(line for line in text.splitlines() if line.startswith(f'"{name}"'))
        values = "[50, 100, 150]" if name == "ctl.Kp" else "[3.5, 9.0]"
        text = text.replace(line, f'"{name}" = {{ values = {values} }}')
    (case.path / "listed.toml").write_text(text, encoding="utf-8")
    answer = case.gmfbo("tune listed.toml")
    assert answer.code == 0, answer.err
    real = [t for t in Study.read(case.path / f"{method}.study").trials if t.source == "IS1"]
    run = {(t.gains["ctl.Kp"], t.gains["ctl.Kd"]) for t in real}
    assert run == {(kp, kd) for kp in (50.0, 100.0, 150.0) for kd in (3.5, 9.0)}
