"""Recordings that begin at rest under what the twin lacks, and such as begin with the twin."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from gmfbo import diagnose
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.physics import CATALOGUE
from tests.diagnosis.short_recordings import (
    SERVO,
    decided,
    diagnosed,
    moves,
    multisine,
    named,
    open_small,
    triangle,
)

pytestmark = pytest.mark.slow

OFFSET = {"constant_torque_offset.level": 0.3}
GRAVITY = {"gravity_torque.sine": 0.1, "gravity_torque.cosine": 0.35}
HIDDEN = {"offset": OFFSET, "gravity": GRAVITY}
PUSHING = (
    "constant_torque_offset",
    "gravity_torque",
    "elastic_return",
    "pulse_disturbance",
    "sensor_offset",
    "coulomb_friction",
)


@cache
def _decided(hidden: str, held: float, *, rest: int | None = None) -> tuple[Decision, bool, int]:
    """Decision, whether the recordings were found to begin at rest, and steps of rest."""
    case = open_small(SERVO.twin(), SERVO.recordings(HIDDEN[hidden], (multisine, moves), held=held))
    try:
        if rest is not None:
            case.simulations.rest = rest
        decision = decided(case, PUSHING)
        return decision, case.simulations.begins_at_rest, case.simulations.rest
    finally:
        case.simulations.close()


def _names(decision: Decision) -> list[str]:
    return [entry.winner.name for entry in decision.rounds]


@pytest.mark.parametrize(("held", "at_rest"), [(0.8, True), (0.0, False)])
def test_a_force_is_found_alone_whether_it_acted_before_or_not(held: float, at_rest: bool) -> None:
    decision, begins_at_rest, rest = _decided("offset", held)
    assert _names(decision) == ["constant_torque_offset"]
    assert begins_at_rest is at_rest
    assert 10 <= rest <= 300
    found = dict(decision.rounds[0].winner.fitted.hypothesis.effects[0].values)
    assert found["level"] == pytest.approx(0.3, rel=0.02)


def test_gravity_that_held_the_axis_before_the_recording_leaves_noise_alone() -> None:
    decision, begins_at_rest, _ = _decided("gravity", 0.8)
    assert _names(decision) == ["gravity_torque"]
    assert begins_at_rest
    found = dict(decision.rounds[0].winner.fitted.hypothesis.effects[0].values)
    assert found["cosine"] == pytest.approx(0.35, rel=0.02)


def test_negative_control_a_twin_that_starts_under_gravity_leaves_a_start_that_never_was() -> None:
    """An offset of the sensor comes nearest to it, and is less likely by ten nats and more."""
    kept, _, _ = _decided("gravity", 0.8)
    started, _, _ = _decided("gravity", 0.8, rest=0)
    assert _names(started) != ["gravity_torque"]
    assert started.model.chi2 > kept.model.chi2 + 20.0


def test_the_augmented_twin_begins_at_rest_as_the_recordings_did() -> None:
    recordings = SERVO.recordings(GRAVITY, (multisine, moves), held=0.8)
    diagnosis = diagnosed(SERVO.twin(), recordings, only=PUSHING[:2])
    assert named(diagnosis) == ["gravity_torque"]
    recorded = recordings[0].signals["position"]
    with diagnosis.augmented_twin() as augmented:
        run = augmented.run(SERVO.gains, recordings[0])
    assert abs(recorded[0]) > 100.0 * SERVO.noise["position"]
    np.testing.assert_allclose(
        run.signal("position")[:50], recorded[:50], atol=6.0 * SERVO.noise["position"]
    )


@pytest.mark.parametrize("start", [1e-5, 0.5])
def test_a_push_is_named_wherever_in_the_recordings_it_acts(start: float) -> None:
    push = {"level": 0.5, "start": start, "duration": 0.1}
    physics = {f"pulse_disturbance.{name}": value for name, value in push.items()}
    recordings = SERVO.recordings(physics, (multisine, moves))
    diagnosis = diagnosed(SERVO.twin(), recordings, only=("pulse_disturbance", "coulomb_friction"))
    assert named(diagnosis) == ["pulse_disturbance"]


@pytest.mark.slow
@pytest.mark.parametrize("held", [0.8, 0.0])
def test_unseen_recordings_begin_as_the_fitted_ones_do(held: float) -> None:
    fitted = SERVO.recordings(OFFSET, (multisine, moves), held=held)
    unseen = SERVO.recordings(OFFSET, (triangle,), held=held, seed=6)
    excluded = [name for name in CATALOGUE if name not in PUSHING[:2]]
    diagnosis = diagnose(SERVO.twin(), fitted, validate=unseen, exclude=excluded, jobs=1)
    assert named(diagnosis) == ["constant_torque_offset"]
    position = diagnosis.fit.signals["position"]
    assert position.augmented < 1.3 * position.noise_floor
    assert position.parameters_only > 5.0 * position.noise_floor


def test_a_friction_needs_no_hold() -> None:
    recordings = SERVO.recordings({"coulomb_friction.level": 0.2}, held=0.8)
    case = open_small(SERVO.twin(), recordings)
    try:
        decision = decided(case, ("coulomb_friction", "constant_torque_offset"))
        assert _names(decision) == ["coulomb_friction"]
    finally:
        case.simulations.close()
