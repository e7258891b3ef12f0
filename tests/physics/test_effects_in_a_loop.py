"""With the parameters that the catalogue sets, elastic elements converge on a moving mass."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.physics import CATALOGUE, Values
from gmfbo.sources.fmu_file.models import models_folder
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu
from tests.physics.excitations import TYPICAL

INERTIA = 0.12  # that of TYPICAL, in all
GRID = 1e-3  # [s] where runs are compared


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    with unpacked_fmu(models_folder() / "physics.fmu") as unpacked:
        yield unpacked


def velocities(folder: Path, name: str, start: Values, step: float) -> NDArray[np.float64]:
    """Velocity of a driven mass under one effect, every 1 ms for 0.4 s; the mass moves exactly."""
    instance = FmuInstance(folder)
    variables = CATALOGUE[name].variables(start, replace(TYPICAL, step=step))
    instance.start(**{key.replace(".", "__"): value for key, value in variables.items()})
    motor = INERTIA - start.get("load_inertia", 0.0)
    position = velocity = 0.0
    rows = []
    for index in range(round(0.4 / step)):
        rows.append(velocity)
        drive = 2.0 * math.sin(4.0 * math.pi * index * step)
        instance.set(state__position=position, state__velocity=velocity, state__command=drive)
        instance.step(index * step, step)
        acceleration = (drive + instance.get("torque")) / motor
        position += (velocity + 0.5 * acceleration * step) * step
        velocity += acceleration * step
    instance.close()
    return np.array(rows)[:: round(GRID / step)]


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("coulomb_friction", {"level": 0.6}),
        ("backlash", {"gap": 2e-3, "load_inertia": 0.2 * INERTIA}),
        ("backlash", {"gap": 2e-3, "load_inertia": 0.8 * INERTIA}),
        ("torsional_compliance", CATALOGUE["torsional_compliance"].starts(TYPICAL)[0]),
        ("torsional_compliance", CATALOGUE["torsional_compliance"].starts(TYPICAL)[-1]),
    ],
)
def test_runs_at_coarse_and_fine_steps_agree(folder: Path, name: str, start: Values) -> None:
    fine = velocities(folder, name, start, 5e-5)
    for step, tolerance in ((1e-3, 0.015), (2e-4, 0.004)):
        error = velocities(folder, name, start, step) - fine
        assert np.sqrt(np.mean(error**2)) < tolerance * np.ptp(fine), step
