"""An archive whose members are written with backslashes."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "05-backslash-archive"
pytestmark = needs_case(CASE)


def test_it_is_inspected_and_run(case: CaseFolder) -> None:
    answer = case.gmfbo("inspect --run backslash.fmu")
    assert answer.code == 0, answer.err
    assert "platforms: linux64" in answer.out
    assert "the member 'binaries\\linux64\\servo.so' is written with a backslash" in answer.out
    assert "tried: 2 steps of 0.001 s went well" in answer.out
