"""A diagnosis keeps the values of each explanation: they simulate what it reported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.diagnosis.diagnosis import Diagnosis
from gmfbo.diagnosis.naming.open_explanations import as_candidate
from gmfbo.diagnosis.result.predictions import PARAMETERS_ONLY
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO, diagnosed, moves, multisine

pytestmark = pytest.mark.slow

FRICTION = ("coulomb_friction", "constant_torque_offset")


@pytest.fixture(scope="module")
def friction() -> Diagnosis:
    recordings = SERVO.recordings({"coulomb_friction.level": 0.2}, (multisine, moves))
    return diagnosed(SERVO.twin(), recordings, only=FRICTION)


def test_the_named_effect_comes_first_and_the_refitted_twin_last(friction: Diagnosis) -> None:
    told = friction.predictions
    assert told is not None
    named, *_, plain = told.explanations
    assert (named.name, named.effects) == ("coulomb_friction", ("coulomb_friction",))
    level = friction.effects[0].parameters["level"].value
    assert named.physics["coulomb_friction.level"] == level
    assert named.parameters == {n: p.value for n, p in friction.parameters.items()}
    assert (plain.name, plain.physics) == (PARAMETERS_ONLY, {})
    assert plain.misfit > 10.0 * named.misfit
    assert named.misfit < 3.0


def test_what_recordings_covered_is_told_with_its_units(friction: Diagnosis) -> None:
    told = friction.predictions
    assert told is not None
    assert told.spans["velocity"].unit == "rad/s"
    assert told.spans["position"].low < 0.0 < told.spans["position"].high
    assert told.spans["load"].low >= 0.0
    assert set(told.noise) == {"position", "torque_command"}


def test_the_values_simulate_what_the_augmented_twin_does(
    friction: Diagnosis, tmp_path: Path
) -> None:
    told = friction.predictions
    assert told is not None
    named = told.explanations[0]
    (recording,) = SERVO.recordings({}, (multisine,))
    with SERVO.twin() as twin, AugmentedTwin(twin, substeps=5) as axis:
        plan = axis.plan(recording, {})
        run = axis.run(plan, named.parameters, named.physics)
    with friction.augmented_twin(tmp_path) as better:
        exported = better.run({}, recording)
    expected = exported.signal("position")
    assert run.held["position"] == pytest.approx(expected, abs=1e-9 + 1e-9 * np.ptp(expected))


def test_an_effect_comes_back_with_its_fixed_values_beside_the_fitted_ones() -> None:
    physics = {"coulomb_friction.level": 0.2, "coulomb_friction.deflection": 1e-5, "other.x": 1.0}
    found = as_candidate("coulomb_friction", physics)
    assert found.values == {"level": 0.2}
    assert found.more == {"deflection": 1e-5}
