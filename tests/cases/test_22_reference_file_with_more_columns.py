"""The reference of a study may be a column of a scope's recording."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "22-reference-file-with-more-columns"
pytestmark = needs_case(CASE)


def test_the_reference_column_is_used(case: CaseFolder) -> None:
    answer = case.gmfbo("ask scope.toml --random-start")
    assert (answer.code, answer.err) == (0, "")
    assert "reference from 0 to 1 rad at 0.1 s" in answer.out
    header = next(
        line
        for line in (case.path / "scope.study/next.csv").read_text().splitlines()
        if not line.startswith("#")
    )
    assert header == "time [s],reference [rad]"


@pytest.mark.slow
def test_real_runs_follow_it(case: CaseFolder) -> None:
    answer = case.gmfbo("tune scope2.toml --random-start")
    assert answer.code == 0
    assert "best observed" in answer.out
    assert "failed" not in answer.out


def test_a_column_of_another_name_is_chosen_and_a_wrong_one_refused(case: CaseFolder) -> None:
    scope, study = case.path / "scope.csv", case.path / "scope.toml"
    scope.write_text(scope.read_text().replace("reference [rad]", "Axis.fSetPos [rad]", 1))
    answer = case.gmfbo("ask scope.toml --random-start")
    assert answer.code == 2
    assert "no signal 'reference'" in answer.err
    named = study.read_text().replace("[reference]", '[reference]\ncolumn = "Axis.fSetPos"')
    study.write_text(named)
    answer = case.gmfbo("ask scope.toml --random-start")
    assert answer.code == 0
    assert "reference from 0 to 1 rad at 0.1 s" in answer.out
