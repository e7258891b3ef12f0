"""Times in ms and us without a unit are told in one line, before anything is simulated."""

from __future__ import annotations

import pytest

from tests.cases.case_folder import CaseFolder, needs_case

CASE = "01-clock-in-ms-us-ns"
pytestmark = needs_case(CASE)
TOLD = {
    "ms.csv": ("rows 1 s apart, 1,000 steps", "time", "ms"),
    "tia_epoch_ms.csv": ("rows 1 s apart, 1,000 steps", "Timestamp", "ms"),
    "us.csv": ("rows 1,000 s apart, 1,000,000 steps", "time", "us"),
}
LAST = {"ms.csv": 0.099, "tia_epoch_ms.csv": 0.199, "us.csv": 0.099}


@pytest.mark.parametrize("recording", TOLD)
@pytest.mark.parametrize(
    "command",
    [
        "check ../servo.toml {}",
        "simulate ../servo.toml --reference {} --out s.csv",
        "diagnose ../servo.toml {} --out d",
    ],
)
def test_the_unit_is_asked_for(command: str, recording: str, case: CaseFolder) -> None:
    apart, column, unit = TOLD[recording]
    answer = case.gmfbo(command.format(recording))
    assert answer.code == 2
    assert answer.err == (
        f"gmfbo: {recording}: {apart} of the twin each; is the time in {unit}? write time = "
        f'{{ column = "{column}", unit = "{unit}" }} in [columns] of the twin file, or unit = "s" '
        "there if it is right"
    )


@pytest.mark.parametrize("recording", TOLD)
def test_the_line_that_is_told_mends_it(recording: str, case: CaseFolder) -> None:
    _, column, unit = TOLD[recording]
    file = case.path.parent / "servo.toml"
    stated = f'\n[columns]\ntime = {{ column = "{column}", unit = "{unit}" }}\n'
    file.write_text(file.read_text() + stated)
    answer = case.gmfbo(f"simulate ../servo.toml --reference {recording} --out s.csv")
    assert answer.code == 0
    assert f"{LAST[recording]} s -> s.csv" in answer.out
