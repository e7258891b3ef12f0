"""The laws on a trajectory are those that physics.fmu computes when it is stepped along it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from gmfbo.physics import CATALOGUE, Effect
from gmfbo.sources.fmu_file.models import models_folder
from tests.fmu_build.fmu_instance import FmuInstance, unpacked_fmu
from tests.physics.excitations import TYPICAL, swing

STEP = 1e-4  # [s]
OUTPUTS = ["torque", "command", "sensor"]


@pytest.fixture(scope="module")
def instance_of() -> Iterator[type[FmuInstance]]:
    """Opens instances of physics.fmu; the folder goes with the module."""
    with unpacked_fmu(models_folder() / "physics.fmu") as folder:

        class Opened(FmuInstance):
            def __init__(self) -> None:
                super().__init__(folder)

        yield Opened


@pytest.mark.parametrize(
    "effect",
    [effect for effect in CATALOGUE.values() if effect.signal is not None],
    ids=lambda effect: effect.name,
)
def test_a_law_is_what_the_fmu_adds_to_its_port(
    effect: Effect, instance_of: type[FmuInstance]
) -> None:
    states = swing(1.5, STEP)
    parameters = {**effect.fixed(TYPICAL), **effect.starts(TYPICAL)[-1]}
    if "deflection" in effect.fixed(TYPICAL):
        parameters["deflection"] = 1e-9  # no bristle to bend: the law has none
    assert effect.signal is not None
    expected = effect.signal(states, parameters)

    instance = instance_of()  # type: ignore[call-arg]
    variables = effect.variables(parameters, TYPICAL)
    instance.start(**{name.replace(".", "__"): value for name, value in variables.items()})
    inputs = {
        "state__position": states.position,
        "state__velocity": states.velocity,
        "state__command": states.command,
    }
    found = instance.run(inputs, OUTPUTS, STEP)[1:, OUTPUTS.index(effect.port)]
    instance.close()

    # The FMU holds values over a step and gives means over it: half a step of lateness.
    error = np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))
    assert error < 0.02
