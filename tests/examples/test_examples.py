"""The examples are what their script makes, and `gmfbo examples` hands them out."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin, Recording, Study, models_folder, step_reference
from gmfbo.cli import main
from tests.examples.make import ARM, EXAMPLES, servo_runs, vendor_fmu, vendor_run, vendor_runs

LAST_DIGIT = 1e-5
"""[deg] What another processor may change in the digits that a log keeps."""


def log(name: str, between: str) -> NDArray[np.float64]:
    """Rows of time, reference, position and torque command."""
    return np.loadtxt(EXAMPLES / name, delimiter=between, skiprows=1)


def test_the_recordings_are_those_of_the_axis_with_friction() -> None:
    for number, table in enumerate(servo_runs()):
        np.testing.assert_allclose(log(f"run{number}.csv", ","), table, atol=1e-8)


def test_control_the_axis_without_friction_has_other_recordings() -> None:
    without = servo_runs({"coulomb_friction.level": 0.0})[0]
    assert np.abs(log("run0.csv", ",")[:, 3] - without[:, 3]).max() > 0.15  # [N m] of 0.2 hidden


def test_the_vendors_logs_are_those_of_its_rig() -> None:
    for number, table in enumerate(vendor_runs()):
        np.testing.assert_allclose(log(f"vendor/log{number}.csv", ";"), table, atol=LAST_DIGIT)


def test_the_played_run_is_that_of_the_rig_along_its_own_reference() -> None:
    played = log("vendor/played.csv", ";")
    np.testing.assert_allclose(
        vendor_run(np.radians(played[:, 1]), 20)[:, 2], played[:, 2], atol=0.006
    )  # [deg] one count of the encoder, which rounding of the reference may move


def test_control_the_rig_without_its_arm_plays_otherwise() -> None:
    played = log("vendor/played.csv", ";")
    without = vendor_run(np.radians(played[:, 1]), 20, {**ARM, "arm.torque": 0.0})
    assert np.abs(without[:, 2] - played[:, 2]).max() > 0.1  # [deg]


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
    assert Recording.read(tour / "run0.csv").time.size == 2500
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


def test_the_axis_under_p_pi_is_the_loop_that_its_file_states(tour: Path) -> None:
    """Against a loop written out here: a mass with viscous friction, current held for a sample."""
    inertia, torque_constant, viscous, step = 0.005, 0.5, 0.02, 1e-3
    kp, kv, ki = 30.0, 1.0, 10.0
    with FmuTwin(tour / "p_pi_axis.toml") as twin:
        gains = {"controller.kp": kp, "controller.kv": kv, "controller.ki": ki}
        run = twin.run(gains, step_reference(1.0, at=0.05, horizon=0.4))
    decay = np.exp(-viscous / inertia * step)
    position = before = velocity = integral = 0.0
    expected = []
    for asked in run.signal("reference"):
        expected.append(position)
        error = kp * (asked - position) - (position - before) / step
        current = np.clip(kv * error + integral, -20.0, 20.0)
        integral += step * ki * error
        before, last = position, torque_constant * current / viscous  # speed that it tends to
        position += last * step + (velocity - last) * (1.0 - decay) * inertia / viscous
        velocity = last + (velocity - last) * decay
    assert np.max(run.signal("current_command")) == 20.0  # the limit acts
    np.testing.assert_allclose(run.signal("position"), expected, rtol=0.0, atol=1e-9)
    assert position == pytest.approx(1.0, abs=1e-3)
