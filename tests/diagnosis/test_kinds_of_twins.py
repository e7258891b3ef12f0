"""Twins with all ports, some and none, open and on wires, each diagnosed as far as it can be.

Friction that is found with all ports: see runs/test_reported_trajectories.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo import FmuTwin
from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.physics import CATALOGUE
from gmfbo.sources.fmu_file.models import models_folder
from tests.diagnosis.servo_recordings import rewritten
from tests.diagnosis.short_recordings import (
    BENCH,
    LOOP,
    PLANT,
    SERVO,
    Axis,
    diagnosed,
    named,
)

FRICTION = {"coulomb_friction.level": 0.25, "coulomb_friction.deflection": 1e-6}
SPLIT = Axis(
    "drive_split",
    "reference",
    {"plant.load.inertia": 0.15},
    {"controller.ctl.Kp": 100.0, "controller.ctl.Kd": 6.0},
    {"position": 2e-5, "torque_command": 0.02, "velocity": 1e-3},
)


def with_ports(folder: Path, *lines: str) -> FmuTwin:
    """Servo axis of which only some ports are known."""
    text = (models_folder() / "servo_axis.toml").read_text()
    ports = text[text.index("[ports]") : text.index("[states]")]
    kept = [line for line in ports.splitlines() if line.split(" ")[0] in lines]
    new = "\n".join(["[ports]", *kept, "", ""]) if kept else ""
    return rewritten("servo_axis", folder, {ports: new})


def untested(diagnosis: Diagnosis) -> dict[str, str]:
    return {entry.name: entry.why for entry in diagnosis.not_testable}


def friction_level(diagnosis: Diagnosis) -> float:
    assert named(diagnosis) == ["coulomb_friction"]
    return diagnosis.effects[0].parameters["level"].value


def swing(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """A current to and fro."""
    return 2.0 * np.sin(3.0 * np.pi * t)


def pushes(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """A current one way, then the other."""
    return 1.5 * np.sign(np.sin(2.2 * np.pi * t + 0.3))


@pytest.mark.slow
def test_what_a_sensor_does_is_named_at_its_port() -> None:
    recordings = SERVO.recordings({"sensor_lag.time": 8e-3})
    diagnosis = diagnosed(SERVO.twin(), recordings, only=("sensor_lag",))
    assert named(diagnosis) == ["sensor_lag"]
    assert diagnosis.effects[0].port == "sensor"


def test_with_all_ports_a_twin_that_lacks_nothing_is_only_refitted() -> None:
    diagnosis = diagnosed(SERVO.twin(), SERVO.recordings({}), only=LOOP)
    assert diagnosis.verdict == "parameters"
    assert diagnosis.effects == ()
    assert diagnosis.next_experiment is None
    for name, value in SERVO.truth.items():
        assert diagnosis.parameters[name].value == pytest.approx(value, rel=0.03)


def test_with_a_torque_port_alone_friction_is_found_and_loops_are_not_testable(
    tmp_path: Path,
) -> None:
    twin = with_ports(tmp_path, "torque")
    diagnosis = diagnosed(twin, SERVO.recordings(FRICTION), only=LOOP)
    assert friction_level(diagnosis) == pytest.approx(0.25, rel=0.02)
    for name, effect in CATALOGUE.items():
        if effect.port != "torque" and name in LOOP:
            assert untested(diagnosis)[name] == f"the twin has no {effect.port} port"


def test_without_ports_only_parameters_are_tested_and_every_effect_says_why(
    tmp_path: Path,
) -> None:
    """Friction is there: that something is missing shows, what it is does not."""
    diagnosis = diagnosed(with_ports(tmp_path), SERVO.recordings(FRICTION))
    assert diagnosis.verdict == "outside_library"
    assert "none of the effects known here can be tested" in str(diagnosis)
    assert diagnosis.effects == ()
    reasons = untested(diagnosis)
    assert list(reasons) == list(CATALOGUE)
    for name, effect in CATALOGUE.items():
        assert reasons[name] == f"the twin has no {effect.port} port"
    assert diagnosis.location.signal_path is None
    cost = diagnosis.cost
    assert {"reading", "running the twin", "validating", "locating"} <= set(cost.stages)
    assert sum(cost.stages.values()) == pytest.approx(cost.seconds, rel=0.1)


def test_an_open_loop_plant_is_kept_near_its_recording_and_shows_its_friction() -> None:
    physics = {"coulomb_friction.level": 0.02, "coulomb_friction.deflection": 1e-6}
    recordings = BENCH.recordings(physics, (swing, pushes))
    diagnosis = diagnosed(BENCH.twin(), recordings, only=PLANT)
    assert friction_level(diagnosis) == pytest.approx(0.02, rel=0.05)
    assert diagnosis.parameters["inertia"].value == pytest.approx(0.0052, rel=0.01)
    assert any("open-loop plant" in note for note in diagnosis.notes)


def test_an_open_loop_plant_that_lacks_nothing_is_only_refitted() -> None:
    """Its inertia is found to 1 %: the loop that keeps it near the recording adds none."""
    diagnosis = diagnosed(BENCH.twin(), BENCH.recordings({}, (swing, pushes)), only=PLANT)
    assert diagnosis.verdict == "parameters"
    for name, value in BENCH.truth.items():
        assert diagnosis.parameters[name].value == pytest.approx(value, rel=0.01)


@pytest.mark.slow
def test_controller_and_plant_on_wires_show_what_acts_between_them() -> None:
    recordings = SPLIT.recordings({"actuator_saturation.limit": 5.0})
    diagnosis = diagnosed(SPLIT.twin(), recordings, only=("actuator_saturation", "sensor_lag"))
    assert named(diagnosis) == ["actuator_saturation"]
    assert diagnosis.effects[0].port == "command"
    assert diagnosis.location.signal_path == "actuator"
