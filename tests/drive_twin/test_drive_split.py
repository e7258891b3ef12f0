"""The drive as controller and plant, joined by wires, is the drive."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

from gmfbo import FmuTwin, Recording, Trajectory, step_reference
from gmfbo.sources.fmu_file.models import models_folder
from tests.drive_twin.drive_runs import CORNERS

PLANT_ONLY = {"friction.scale": 2.0, "load.unbalance": 3.0, "map.noise": 0.5, "map.seed": 3}
SIGNALS = ("position", "torque_command", "velocity")


def run_both(
    gains: tuple[float, float], plant: dict[str, float], reference: Recording, step: float = 1e-3
) -> tuple[Trajectory, Trajectory]:
    """Whole and split drive; parameters are those of the plant."""
    with FmuTwin(models_folder() / "drive_twin.toml", isolated=False, step=step) as twin:
        whole = twin.run(gains, reference, parameters=plant)
    renamed = {f"plant.{name}": value for name, value in plant.items()}
    with FmuTwin(models_folder() / "drive_split.toml", isolated=False, step=step) as twin:
        split = twin.run(gains, reference, parameters=renamed)
    assert whole.status == split.status == "ok"
    return whole, split


@pytest.mark.parametrize("plant", [{}, PLANT_ONLY], ids=["nominal", "altered"])
@pytest.mark.parametrize("gains", CORNERS)
def test_the_split_drive_is_the_whole_drive_to_the_last_bit(
    gains: tuple[float, float], plant: dict[str, float]
) -> None:
    whole, split = run_both(gains, plant, step_reference())
    for name in SIGNALS:
        np.testing.assert_array_equal(whole.signal(name), split.signal(name), err_msg=name)


def test_they_agree_at_a_shorter_communication_step_too() -> None:
    whole, split = run_both((100.0, 6.0), {}, step_reference(sample_time=1e-4), step=1e-4)
    for name in SIGNALS:
        np.testing.assert_array_equal(whole.signal(name), split.signal(name), err_msg=name)


def variables(model: str) -> dict[str, dict[str, Any]]:
    path = models_folder().parent / "fmu_build" / model / "model.toml"
    return {entry["name"]: entry for entry in tomllib.loads(path.read_text())["variable"]}


def test_the_parts_declare_the_parameters_of_the_whole_and_no_others() -> None:
    def parameters(model: str) -> dict[str, dict[str, Any]]:
        return {k: v for k, v in variables(model).items() if v["causality"] == "parameter"}

    controller, plant = parameters("drive_controller"), parameters("drive_plant")
    assert not controller.keys() & plant.keys()
    assert controller | plant == parameters("drive_twin")
