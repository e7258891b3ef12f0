"""An FMU that defines 1/min as an angular velocity, and g as an acceleration, is believed."""

from __future__ import annotations

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "12-fmu-states-its-unit"
pytestmark = needs_case(CASE)


def test_the_recording_is_compared_in_the_units_that_the_fmu_defines(case: CaseFolder) -> None:
    answer = case.gmfbo("simulate rpm.toml --reference x.csv --out s.csv")
    assert answer.code == 0
    errors = answer.out.partition("over range)")[2].split()
    assert (errors[0], errors[3]) == ("velocity", "acceleration")
    # Another solver made the recording; one wrong unit is 90 % or more of the range.
    assert float(errors[1]) < 0.5
    assert float(errors[4]) < 5.0
    header = (case.path / "s.csv").read_text().partition("time [s]")[2].splitlines()[0]
    assert "velocity [rad/s]" in header
    assert "acceleration [m/s2]" in header
