"""Units in names, after `in`, after a slash and in words are read, shown and kept."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "11-unit-in-the-name"
pytestmark = needs_case(CASE)
READ = {
    "esp32_deg.csv": (
        "time_ms ms 200 0 199 time reference_deg deg 200 0 22.918 reference "
        "position_deg deg 200 0 22.907 position torque_command_Nm Nm 200 -0.30801 1.2069 "
        "torque_command"
    ),
    "in.csv": "Time in ms ms 200 0 199 time reference in rad rad 200 0 0.4 reference",
    "slash.csv": "time/ms ms 200 0 199 time reference/rad rad 200 0 0.4 reference",
    "words.csv": "time Milliseconds 200 0 199 time reference Deg 200 0 22.918 reference",
}


@pytest.mark.parametrize("recording", READ)
def test_columns_shows_what_was_read_and_misses_nothing(recording: str, case: CaseFolder) -> None:
    answer = case.gmfbo(f"columns ../servo.toml {recording}")
    assert answer.code == 0
    assert READ[recording] in answer.out
    assert "a guess" not in answer.out
    assert "not found" not in answer.out


@pytest.mark.parametrize("recording", READ)
def test_the_twin_meets_the_recording(recording: str, case: CaseFolder) -> None:
    answer = case.gmfbo(f"simulate ../servo.toml --reference {recording} --out s.csv")
    assert answer.code == 0
    errors = answer.out.partition("over range)")[2].split()
    assert (errors[0], errors[3]) == ("position", "torque_command")
    assert max(float(errors[1]), float(errors[4])) < 1e-4  # [%]


def test_a_column_that_the_twin_file_names_is_in_the_unit_of_its_name(case: CaseFolder) -> None:
    file = case.path.parent / "servo.toml"
    named = '\n[columns]\nposition = "position_deg"\n'
    file.write_text(file.read_text() + named)
    answer = case.gmfbo("simulate ../servo.toml --reference esp32_deg.csv --out s.csv")
    assert "position_deg as position [deg]" in answer.out
    assert float(answer.out.partition("over range)")[2].split()[1]) < 1e-4
