"""A gain of the sensor that a drive within its tolerance explains as well is not named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gmfbo.diagnosis.naming.conditions import is_small_elsewhere
from gmfbo.diagnosis.naming.decision import Evidence
from tests.diagnosis.naming.linear_evidences import WINDOWS, direction, evidence_of
from tests.diagnosis.short_recordings import (
    SERVO,
    climb,
    diagnosed,
    moves,
    multisine,
    named,
    triangle,
)

BEFORE = 20.0 * direction(1)


def shown(name: str, gain: float) -> Evidence:
    residual = np.sqrt(400.0 - gain) * direction(1)
    return replace(evidence_of(name, residual, BEFORE), gains=np.full(WINDOWS, gain / WINDOWS))


def test_what_the_other_end_of_the_loop_explains_as_well_and_is_small_there() -> None:
    scale = shown("sensor_scale", 42.4)
    assert is_small_elsewhere(scale, [shown("actuator_gain_loss", 42.2)])
    assert not is_small_elsewhere(scale, [shown("actuator_gain_loss", 30.0)])
    assert not is_small_elsewhere(scale, [shown("coulomb_friction", 42.2)])
    assert not is_small_elsewhere(scale, [])


@pytest.mark.slow
@pytest.mark.parametrize(("loss", "names"), [(0.042, 0), (0.12, 1)])
def test_a_torque_constant_that_is_off_as_such_are_is_no_physics(loss: float, names: int) -> None:
    """Of a twin whose inertia and friction were measured, so that nothing makes up for it."""
    axis = replace(SERVO, truth={})
    twin = axis.twin()
    twin.file = twin.file.model_copy(update={"uncertain": {}})
    references = (multisine, moves, triangle, climb)
    recordings = axis.recordings({"actuator_gain_loss.loss": loss}, references, seconds=2.5)
    found = named(diagnosed(twin, recordings, only=("actuator_gain_loss", "sensor_scale")))
    assert set(found) <= {"actuator_gain_loss", "sensor_scale"}
    assert len(found) == names
