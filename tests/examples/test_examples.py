"""The examples are what their script makes, and `gmfbo examples` hands them out."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from gmfbo import Recording, Study, models_folder
from gmfbo.cli import main
from tests.examples.make import EXAMPLES, FRICTION, record, sine, vendor_fmu

LAST_DIGIT = 1e-6
"""[rad, N m] What another processor may change in the digits that a log keeps."""


def logged(name: str) -> np.ndarray:
    """Reference, position and torque command of a log, a row each instant."""
    cells = "," if name.startswith("run") else ";"
    return np.loadtxt(EXAMPLES / name, delimiter=cells, skiprows=1)[:, 1:]


def test_a_log_is_that_of_the_axis_with_friction() -> None:
    position, torque = record(sine(0.9), {**FRICTION, "encoder.seed": 1})
    np.testing.assert_allclose(
        logged("run1.csv"), np.column_stack([sine(0.9), position, torque]), atol=LAST_DIGIT
    )


def test_control_the_axis_without_friction_has_another_log() -> None:
    _, torque = record(sine(0.9), {"encoder.seed": 1})
    assert np.abs(logged("run1.csv")[:, 2] - torque).max() > 0.1  # [N m] of 0.2 that are hidden


def test_the_vendors_log_is_in_degrees() -> None:
    assert np.abs(logged("vendor/log0.csv")[:, 0]).max() == pytest.approx(np.degrees(0.4), abs=1e-3)


def test_the_vendors_fmu_is_the_twin_under_other_names() -> None:
    with zipfile.ZipFile(EXAMPLES / "vendor/x7.fmu") as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    assert members == vendor_fmu(), "run python -m tests.examples.make"
    with zipfile.ZipFile(models_folder() / "servo_axis.fmu") as archive:
        ours = {name: archive.read(name) for name in archive.namelist()}
    assert {name for name in ours if ours[name] != members[name]} == {"modelDescription.xml"}


@pytest.fixture(scope="module")
def tour(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("new") / "deep" / "tour"
    assert main(["examples", str(folder)]) == 0
    return folder


def test_every_file_is_handed_out_whole(tour: Path) -> None:
    for source in EXAMPLES.rglob("*"):
        if source.is_file():
            assert (tour / source.relative_to(EXAMPLES)).read_bytes() == source.read_bytes()
    assert (tour / "servo_axis.fmu").is_file()
    assert (tour / "demo_axis.fmu").is_file()


def test_every_file_is_told_in_the_readme_beside_them(tour: Path) -> None:
    told = (tour / "README.md").read_text(encoding="utf-8")
    names = {path.relative_to(tour).as_posix() for path in tour.rglob("*.*")} - {"README.md"}
    assert {name for name in names if f"`{name}`" not in told} == {"run1.csv", "run2.csv"}


def test_recordings_and_study_load_as_they_are(tour: Path) -> None:
    assert Recording.read(tour / "run0.csv").time.size == 1500
    study = Study.read(tour / "joint.toml")
    assert study.location == tour / "joint.study"


def test_a_folder_that_holds_files_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "run0.csv"
    mine.write_text("mine")
    assert main(["examples", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert f"expected a new or empty folder, but '{tmp_path}' holds files; name another" in said
    assert said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["run0.csv"]
    assert mine.read_text() == "mine"


def test_a_folder_that_cannot_be_made_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert main(["examples", str(tmp_path / "file" / "tour")]) == 2
    said = capsys.readouterr().err
    assert "expected a folder that can be made" in said
    assert said.count("\n") == 1
