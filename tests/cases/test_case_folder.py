"""A case is copied, unpacked and told where the models are."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from gmfbo import FmuTwin, models_folder
from tests.cases.case_folder import CaseFolder, copied

TWIN = """name = "servo"
fmu = "MODELS/servo_axis.fmu"
step = 1e-3
[inputs]
reference = "reference"
[outputs]
position = "position"
"""


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    folder = tmp_path / "cases"
    (folder / "01-some").mkdir(parents=True)
    (folder / "servo.toml").write_text(TWIN)
    (folder / "01-some" / "rec.csv").write_text("time,MODELS\n")
    (folder / "01-some" / "packed.csv.gz").write_bytes(gzip.compress(b"time,position\n"))
    return folder


def test_a_packed_recording_is_unpacked(cases: Path, tmp_path: Path) -> None:
    folder = copied(cases, "01-some", tmp_path)
    assert (folder / "packed.csv").read_text() == "time,position\n"
    assert not (folder / "packed.csv.gz").exists()


def test_the_twin_file_beside_the_cases_opens(cases: Path, tmp_path: Path) -> None:
    folder = copied(cases, "01-some", tmp_path)
    with FmuTwin(folder / ".." / "servo.toml") as twin:
        assert twin.file.name == "servo"
    assert models_folder().as_posix() in (tmp_path / "servo.toml").read_text()


def test_control_recordings_stay_as_they_are(cases: Path, tmp_path: Path) -> None:
    folder = copied(cases, "01-some", tmp_path)
    assert (folder / "rec.csv").read_text() == "time,MODELS\n"


def test_a_command_runs_in_the_folder_on_the_files_it_matches(cases: Path, tmp_path: Path) -> None:
    case = CaseFolder(copied(cases, "01-some", tmp_path))
    answer = case.gmfbo("check ../servo.toml r*.csv")
    assert answer.code == 2
    assert "rec.csv" in answer.err
