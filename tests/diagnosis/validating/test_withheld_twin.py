"""A twin that meets unseen recordings worse than it came is not handed back, and that is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo import diagnose
from gmfbo.cli import main
from gmfbo.cli.diagnosis.diagnosis_screen import screenful
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.page.page import diagnosis_page
from gmfbo.diagnosis.result.estimated import EstimatedParameter
from gmfbo.errors import InputError
from gmfbo.physics import CATALOGUE
from tests.diagnosis.example_diagnoses import FIT, friction
from tests.diagnosis.short_recordings import SERVO, moves, multisine, triangle

SAID = "the twin as it came meets the unseen recordings better"
FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
PARAMETER = EstimatedParameter(0.01, 0.0101, "kg.m2", 0.0099, 0.0103)
WITHHELD = replace(friction(), fit=replace(FIT, twin_is_withheld=True))


def diagnosed(physics: dict[str, float]) -> Diagnosis:
    """Fitted to an axis with friction, and scored on one with other physics."""
    fitted = SERVO.recordings(FRICTION, (multisine, moves))
    unseen = SERVO.recordings(physics, (triangle,))
    excluded = [name for name in CATALOGUE if name != "coulomb_friction"]
    return diagnose(SERVO.twin(), fitted, unseen, exclude=excluded, jobs=1)


def test_a_twin_of_another_axis_is_withheld(tmp_path: Path) -> None:
    found = diagnosed({})
    assert found.fit.twin_is_withheld
    assert found.augmentation is None
    assert SAID in found.sentence
    with pytest.raises(InputError, match=SAID):
        found.augmented_twin()
    found.save(tmp_path)
    assert not (tmp_path / "augmented.fmu").exists()
    assert Diagnosis.from_json(tmp_path).fit.twin_is_withheld


def test_a_twin_of_the_same_axis_is_handed_back() -> None:
    """Negative control."""
    found = diagnosed(FRICTION)
    assert not found.fit.twin_is_withheld
    assert found.augmentation is not None
    assert SAID not in found.sentence


def test_it_is_said_in_terminal_prompt_and_report() -> None:
    page = diagnosis_page(WITHHELD)
    assert SAID in " ".join(" ".join(screenful(WITHHELD)).split())
    assert SAID in repr(WITHHELD)
    assert SAID in page
    assert SAID not in diagnosis_page(friction())


@pytest.mark.parametrize("command", [["simulate", "--out", "x.csv"], ["check", "run.csv"]])
def test_a_command_that_is_given_it_says_why_it_is_not_there_and_what_to_use(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    inertia = replace(PARAMETER, stated="servo_axis.toml, line 21")
    replace(WITHHELD, parameters={"inertia": inertia}).save(tmp_path)
    name, *rest = command
    assert main([name, str(tmp_path / "augmented.toml"), *rest]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert SAID in told
    assert told.endswith("use the one that was diagnosed, servo_axis.toml\n")


def test_control_where_no_twin_was_withheld_the_file_is_only_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    friction().save(tmp_path)
    assert main(["simulate", str(tmp_path / "augmented.toml"), "--out", "x.csv"]) == 2
    told = capsys.readouterr().err
    assert "no twin file at" in told
    assert SAID not in told
