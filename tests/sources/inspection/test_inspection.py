"""What an FMU is, told without running it, and a twin file to begin from."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from gmfbo import FmuTwin
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.inspection.inspection import inspect_fmu, starting_twin_file
from gmfbo.sources.inspection.role_guesses import guess_roles
from gmfbo.sources.twin_file.twin_file import TwinFile
from tests.sources.conftest import TEST_FMUS

if TYPE_CHECKING:
    from pathlib import Path

    from tests.sources.conftest import Repack

ALL = sorted([*models_folder().glob("*.fmu"), *TEST_FMUS.glob("*.fmu")])


def test_the_linear_axis_is_told_as_it_was_declared() -> None:
    report = inspect_fmu(models_folder() / "linear_axis.fmu")
    assert report.name == "linear_axis"
    assert report.fmi_version == "2.0"
    assert report.kinds == ("co-simulation",)
    assert report.obstacle == ""
    assert report.findings == ()
    assert report.default_step == 1e-3
    assert report.capabilities["canGetAndSetFMUstate"] is True
    assert report.capabilities["canBeInstantiatedOnlyOncePerProcess"] is False
    assert "linux64" in report.platforms
    names = [variable.name for variable in report.inputs]
    assert names == ["reference", "port.force", "port.command", "port.sensor"]
    mass = next(variable for variable in report.parameters if variable.name == "mass")
    assert (mass.unit, mass.start, mass.minimum, mass.maximum) == ("kg", 95.1089, 1.0, 1e4)
    assert mass.tunable


def test_what_cannot_run_here_is_told_and_not_refused() -> None:
    report = inspect_fmu(TEST_FMUS / "model_exchange.fmu")
    assert report.kinds == ("model exchange",)
    assert "ask its vendor to export FMI 2.0 co-simulation" in report.obstacle
    assert "has no binary for this machine" in inspect_fmu(TEST_FMUS / "no_binary.fmu").obstacle


def test_violations_of_the_standard_are_findings_and_no_refusal(repack: Repack) -> None:
    report = inspect_fmu(repack(edits={' start="95.1089"': ""}))
    assert any("mass" in finding and "start" in finding for finding in report.findings)
    assert all("\n" not in finding for finding in report.findings)
    assert report.obstacle == ""


def test_inspecting_a_crashing_fmu_runs_none_of_its_code() -> None:
    assert inspect_fmu(TEST_FMUS / "faulty.fmu").findings == ()


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_the_starting_twin_file_is_a_valid_twin_file(path: Path) -> None:
    report = inspect_fmu(path)
    twin = TwinFile.parse(starting_twin_file(report), "start.toml")
    assert {entry.variable for entry in twin.outputs.values()} == {v.name for v in report.outputs}
    assert twin.gains == {}
    assert twin.ports == {}


@pytest.mark.parametrize("path", sorted(models_folder().glob("*.fmu")), ids=lambda path: path.stem)
def test_the_guesses_of_the_starting_twin_file_fit_the_fmu(path: Path, tmp_path: Path) -> None:
    """With every comment sign at the start of a line removed it still binds."""
    text = starting_twin_file(inspect_fmu(path))
    text = re.sub(r"(?m)^# ", "", text).replace(path.name, str(path))
    (tmp_path / "twin.toml").write_text(text)
    twin = FmuTwin(tmp_path / "twin.toml")
    assert len(twin.file.parameters) >= 2


def test_names_that_toml_cannot_hold_bare_become_keys(repack: Repack) -> None:
    fmu = repack(
        edits={'name="true_position"': 'name="der(x)[1]"', 'name="force"': 'name="der x 1"'}
    )
    twin = TwinFile.parse(starting_twin_file(inspect_fmu(fmu)), "start.toml")
    assert twin.outputs["der_x_1"].variable == "der(x)[1]"
    assert twin.outputs["der_x_1_2"].variable == "der x 1"


SHIPPED = ("servo_axis", "linear_axis", "drive_twin", "motor_bench", "servo_pendulum", "damper")
MISSED = {("servo_pendulum", "load_torque")}  # the twin file takes one of two that may stand for it
EXTRA = {("drive_twin", "current")}


@pytest.mark.parametrize("name", SHIPPED)
def test_the_guesses_are_what_the_shipped_twin_file_says(name: str) -> None:
    """The twin files were written by hand, by those who made the models."""
    report = inspect_fmu(models_folder() / f"{name}.fmu")
    guessed = guess_roles(report.inputs, report.outputs, report.parameters, report.local)
    file = TwinFile.read(models_folder() / f"{name}.toml")
    assert {g.key: g.variable.name for g in guessed.ports} == file.ports
    assert {g.key: g.variable.name for g in guessed.roles} == file.roles
    assert {v.name for v in guessed.gains} == set(file.gains)
    states = {g.key: g.variable.name for g in guessed.states if (name, g.key) not in EXTRA}
    differing = {key for key, _ in states.items() ^ file.states.items()}
    assert {(name, key) for key in differing} <= MISSED
    assert {v.name for v in guessed.uncertain} & set(file.uncertain)
    driven = {entry.variable for entry in file.inputs.values()}
    assert {v.name for v in guessed.inputs} == driven - {"enabled"}


def test_a_guess_says_that_it_is_one_and_what_it_rests_on() -> None:
    text = starting_twin_file(inspect_fmu(models_folder() / "servo_axis.fmu"))
    assert '# torque = "tau_load"  # guess: its name or description says that it adds, ' in text
    assert '# position = "true_position"  # guess: its name, unit rad\n' in text
    assert '# inertia = "inertia"  # guess: the unit kg.m2\n' in text
    tables = re.findall(r"(?m)^\[(\w+)\].*guesses, remove the # where one is right$", text)
    assert tables == ["gains", "uncertain", "ports", "states", "roles"]
    assert "##" not in text
    assert "'gmfbo init FMU LOG --out DIR' writes" in text


def test_a_plant_alone_is_shown_how_a_controller_joins_it() -> None:
    text = starting_twin_file(inspect_fmu(models_folder() / "drive_plant.fmu"))
    assert '## "plant.torque_command" = "controller.u"' in text
    assert '## "controller.measured" = "plant.true_position"' in text
