"""`gmfbo check` as a person meets it: what it prints, writes and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gmfbo.cli import main
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.short_recordings import SERVO

TWIN = models_folder() / "servo_axis.toml"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("recordings")
    recordings = SERVO.recordings({}, seconds=1.0)
    latched = np.repeat(recordings[1].signals["torque_command"][::4], 4)
    recordings[1] = recordings[1].with_signals({"torque_command": latched})
    for recording in recordings:
        write_recording(recording, folder / recording.name)
    return [folder / recording.name for recording in recordings]


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def test_faults_come_first_with_a_cure_and_the_status_is_zero(
    files: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "check.json"
    assert run("check", TWIN, *files, "--json", out) == 0
    shown, said = capsys.readouterr()
    lines = shown.splitlines()
    assert lines[0] == "servo axis: 2 recordings, 1 thing to look at"
    assert lines[1].startswith("! rec1.csv, torque command: holds each value for 4 rows")
    assert lines[2].startswith("  -> log it at its own rate")
    assert any(line.startswith("coulomb friction") and "N m" in line for line in lines)
    assert max(map(len, lines[:-1])) <= 79
    assert len(lines) < 45
    assert said == ""
    content = json.loads(out.read_text(encoding="utf-8"))
    assert content["findings"][0]["kind"] == "latched_column"


def test_all_shows_every_effect(files: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check", TWIN, files[0], "--all") == 0
    shown = capsys.readouterr().out
    assert "nothing wrong with it was seen" in shown
    assert "stribeck friction" in shown
    assert "more effects" not in shown


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere.csv",), "nowhere.csv"),
        ((), "REC"),
        (("REC", "--json", "."), "expected a file, but '.' is a folder"),
        (("REC", "--json", "none/x.json"), "there is no folder 'none'"),
        (("gap.csv",), "there is a gap"),
    ],
)
def test_bad_input_is_one_line_and_status_two(
    arguments: tuple[str, ...],
    said: str,
    files: list[Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = files[0].read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "gap.csv").write_text("".join(lines[:400] + lines[410:]), encoding="utf-8")
    named = [str(files[0]) if argument == "REC" else argument for argument in arguments]
    assert run("check", TWIN, *named) == 2
    text = capsys.readouterr().err
    assert text.startswith("gmfbo: ")
    assert text.count("\n") == 1
    assert said in text


def test_help_names_its_options(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check", "--help") == 0
    shown = capsys.readouterr().out
    assert "--json" in shown
    assert "--all" in shown
