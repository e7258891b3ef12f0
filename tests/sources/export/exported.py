"""Augmented twins of the project's own models, as the tests of the export need them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.sources.export.export import AugmentedFmu, PhysicsParameter, export_augmented
from gmfbo.sources.fmu_file.models import models_folder
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.response import Response
from gmfbo.sources.twin.twin import FmuTwin

SUBSTEPS = 10
STEPS = 600


@dataclass(frozen=True)
class Case:
    """A twin file of the project and the physics that it is given.

    Attributes
    ----------
    model : str
        Name of the twin file.
    physics : mapping of str to float
        Parameters of physics.fmu.
    parameters : mapping of str to float
        Refitted parameters of the twin.
    amplitude : float
        Of the sine that drives the first input [its unit].
    """

    model: str
    physics: Mapping[str, float]
    parameters: Mapping[str, float]
    amplitude: float = 0.5

    @property
    def twin_file(self) -> Path:
        return models_folder() / f"{self.model}.toml"


BACKLASH = {
    "backlash.gap": 5e-3,
    "backlash.load_inertia": 4e-3,
    "backlash.stiffness": 500.0,
    "backlash.damping": 0.5,
}
CASES = {
    "axis": Case("linear_axis", {"coulomb_friction.level": 20.0}, {"mass": 80.0}, 0.05),
    "servo": Case(
        "servo_axis",
        {
            "coulomb_friction.level": 0.05,
            "cogging_torque.wavenumber_1": 24.0,
            "cogging_torque.sine_1": 0.02,
            "actuator_saturation.limit": 0.8,
            "actuator_lag.time": 2e-3,
            "sensor_eccentricity.sine": 1e-3,
            "sensor_eccentricity.cosine": -5e-4,
        },
        {"inertia": 0.012, "viscous": 0.03},
    ),
    "backlash": Case("servo_axis", BACKLASH, {"inertia": 0.006}),
    "bench": Case(
        "motor_bench", {"coulomb_friction.level": 0.02, "transport_delay.delay": 1.3e-3}, {}
    ),
    "drive": Case("drive_twin", {"gravity_torque.sine": 1.0}, {"load.inertia": 0.12}),
    "split": Case(
        "drive_split",
        {
            "stribeck_friction.level": 0.5,
            "stribeck_friction.breakaway": 1.0,
            "stribeck_friction.velocity": 0.3,
            "actuator_saturation.limit": 3.0,
            "sensor_offset.level": 0.01,
        },
        {"plant.load.inertia": 0.12},
    ),
}


def named(values: Mapping[str, float]) -> list[PhysicsParameter]:
    """Parameters of named effects; units do not change what is simulated."""
    return [PhysicsParameter(name, value, "1", name) for name, value in values.items()]


def export_case(
    case: Case,
    folder: Path,
    *,
    substeps: int = SUBSTEPS,
    physics: Sequence[PhysicsParameter] | None = None,
) -> AugmentedFmu:
    """Export a case into a folder."""
    folder.mkdir(exist_ok=True)
    with FmuTwin(case.twin_file) as twin, AugmentedTwin(twin, substeps=substeps) as augmented:
        return export_augmented(
            twin,
            folder,
            parameters=case.parameters,
            physics=named(case.physics) if physics is None else physics,
            settings=augmented.settings,
            substeps=substeps,
        )


def excitation(case: Case, steps: int = STEPS) -> Recording:
    """A sine of growing frequency on the twin's first input."""
    with FmuTwin(case.twin_file) as twin:
        time = np.arange(steps + 1, dtype=np.float64) * twin.step
        (signal,) = twin.file.inputs
    swept = 2.0 * np.pi * (2.0 * time + 3.0 * time**2)
    return Recording(time=time, signals={signal: case.amplitude * np.sin(swept)})


def diagnosed(
    case: Case,
    recording: Recording,
    *,
    substeps: int = SUBSTEPS,
    at_ports: Mapping[str, NDArray[np.float64]] | None = None,
) -> Response:
    """What the diagnosis simulates: twin and physics stepped by the C master."""
    with (
        FmuTwin(case.twin_file) as twin,
        AugmentedTwin(twin, substeps=substeps, isolated=False) as augmented,
    ):
        plan = augmented.plan(recording, case.parameters)
        return augmented.run(plan, case.parameters, case.physics, excitation=at_ports)
