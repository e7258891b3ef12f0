"""An FMU that wants to know the stop time."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "06-needs-stop-time"
pytestmark = needs_case(CASE)


def test_the_refusal_names_the_line_and_the_line_helps(case: CaseFolder) -> None:
    refused = case.gmfbo("simulate needs_stop.toml --out s.csv")
    assert refused.code == 3
    assert "put 'stop_time = true' above the tables of the twin file" in refused.err
    twin = case.path / "needs_stop.toml"
    twin.write_text("stop_time = true\n" + twin.read_text(encoding="utf-8"), encoding="utf-8")
    answer = case.gmfbo("simulate needs_stop.toml --out s.csv")
    assert answer.code == 0, answer.err
    assert "1101 rows, 1.1 s" in answer.out
