"""`gmfbo experiment` and `gmfbo compensate` as a person meets them: files, screen, exit status."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gmfbo import Recording
from gmfbo.cli import main
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY, Explanation
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.compensation.compensation_cases import diagnosis_of
from tests.diagnosis.short_recordings import SERVO, SERVO_TRUTH, multisine

TWIN = models_folder() / "servo_axis.toml"
LIMITS = """position = [-0.5, 0.5]   # [rad]
velocity = 6.0
acceleration = 100.0
jerk = 8000.0
torque = 2.0
duration = 3.0
"""
FRICTION = {"coulomb_friction.level": 0.2}


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def complaint(capsys: pytest.CaptureFixture[str]) -> str:
    text = capsys.readouterr().err
    assert text.startswith("gmfbo: ")
    assert text.count("\n") == 1
    return text


@pytest.fixture
def limits(tmp_path: Path) -> Path:
    path = tmp_path / "limits.toml"
    path.write_text(LIMITS)
    return path


@pytest.fixture
def found(tmp_path: Path) -> Path:
    """Folder of a diagnosis that names Coulomb friction."""
    diagnosis = diagnosis_of({"coulomb_friction": {"level": 0.2}})
    told = diagnosis.predictions
    assert told is not None
    named = replace(told.explanations[0], parameters=SERVO_TRUTH)
    plain = Explanation(PARAMETERS_ONLY, (), SERVO_TRUTH, {}, 500.0)
    saved = replace(diagnosis, predictions=replace(told, explanations=(named, plain)))
    (tmp_path / "found").mkdir()
    (tmp_path / "found" / "diagnosis.json").write_text(saved.to_json())
    return tmp_path / "found"


def test_the_next_reference_is_written_and_told(
    limits: Path, found: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "next.csv"
    assert run("experiment", TWIN, "--limits", limits, "--diagnosis", found, "--out", out) == 0
    shown = capsys.readouterr().out
    assert all(len(line) <= 79 for line in shown.splitlines() if str(tmp_path) not in line)
    told = " ".join(shown.split())
    for word in ("play ", "reaches ", "of -0.5 to 0.5", "of 2 N.m", "predicted ", "shows "):
        assert word in told
    text = out.read_text()
    assert text.startswith("# gmfbo = ")
    assert "time [s],reference [rad]\n" in text
    with SERVO.twin() as twin:
        assert Recording.read(out, twin).time[-1] <= 3.0


def test_what_was_observed_is_held_against_what_was_predicted(
    found: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (recording,) = SERVO.recordings(FRICTION, (multisine,), seconds=2.0, seed=8)
    write_recording(recording, tmp_path / "seen.csv")
    seen = tmp_path / "seen.csv"
    assert run("experiment", TWIN, "--diagnosis", found, "--observed", seen) == 0
    shown = capsys.readouterr().out
    assert "seen.csv strongly supports coulomb friction" in shown
    assert "the refitted twin alone" in shown
    (told,) = json.loads((found / "confirmation.json").read_text())["runs"]
    assert (told["outcome"], told["supports"]) == ("supports", ["coulomb_friction"])
    assert told["sentence"].split(":")[0] in shown.replace("\n", " ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--out", "next.csv"], "expected --limits with the limits of the axis"),
        (["--limits", "limits.toml"], "--out: expected a file ending in .csv, got 'nothing'"),
        (["--limits", "limits.toml", "--out", "next.txt"], "got 'next.txt'"),
        (["--limits", "limits.toml", "--out", "no/next.csv"], "there is no folder 'no'"),
        (["--limits", "no.toml", "--out", "next.csv"], "no limits file at 'no.toml'"),
        (["--observed", "seen.csv"], "--observed: expected --diagnosis"),
        (["--observed", "a.csv", "--diagnosis", "found", "--out", "b.csv"], "leave them out"),
        (["--observed", "a.csv", "--diagnosis", "nowhere"], "no diagnosis at"),
    ],
)
def test_what_is_missing_or_contradicts_is_one_line(
    arguments: list[str],
    message: str,
    limits: Path,
    found: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(limits.parent)
    assert run("experiment", TWIN, *arguments) == 2
    assert message in complaint(capsys)
    assert not (limits.parent / "next.csv").exists()


def test_limits_that_nothing_keeps_are_one_line(
    limits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    limits.write_text(LIMITS.replace("position = [-0.5, 0.5]", "position = [0.2, 0.5]"))
    assert run("experiment", TWIN, "--limits", limits, "--out", tmp_path / "next.csv") == 2
    assert "stands at 0 and the limits of the position are 0.2 to 0.5" in complaint(capsys)


@pytest.mark.parametrize("ending", ["csv", "c", "st"])
def test_a_compensation_is_written_and_told(
    ending: str, found: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / f"friction.{ending}"
    assert run("compensate", found, "--out", out, "--smoothing", "0.1") == 0
    shown = capsys.readouterr().out
    assert "torque at the motor shaft [N.m]: coulomb_friction(velocity)" in shown
    assert str(out) in shown.replace("\n", "")
    text = out.read_text()
    assert "to ADD" in text
    assert "0.1" in text
    assert ("double torque_compensation(double velocity)" in text) == (ending == "c")
    assert ("FUNCTION_BLOCK torque_compensation" in text) == (ending == "st")


def test_where_nothing_can_be_compensated_the_status_is_two(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "diagnosis.json").write_text(
        diagnosis_of({"transport_delay": {"delay": 1e-3}}).to_json()
    )
    assert run("compensate", tmp_path, "--out", tmp_path / "x.csv") == 2
    assert "it named only transport delay: tune the gains" in complaint(capsys)
    assert not (tmp_path / "x.csv").exists()


@pytest.mark.parametrize(
    ("out", "message"),
    [
        ("x.txt", "expected a file ending in .csv, .c or .st, got"),
        ("no/x.c", "the folder does not"),
    ],
)
def test_a_compensation_that_cannot_be_written_is_one_line(
    out: str, message: str, found: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("compensate", found, "--out", tmp_path / out) == 2
    assert message in complaint(capsys)
