"""A torque that passes is found with its time, in the recording that has it or in all of them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pytest

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.regression import Regression
from gmfbo.diagnosis.screening import pulses
from gmfbo.diagnosis.screening.pulses import (
    EVERY,
    LEAST_PULSE_GAIN,
    Pulse,
    pulse_change,
    strongest_pulse,
)
from gmfbo.diagnosis.screening.repeating_and_passing import find_lines
from tests.diagnosis.port_cases import PortCase, open_servo, port_case
from tests.diagnosis.short_recordings import SERVO, diagnosed, moves, multisine, named

START, DURATION = 0.9, 0.12
"""[s] Of the pulses that are hidden."""

ALL = (0, 1, 2)


@pytest.fixture
def servo(right_servo: PortCase) -> PortCase:
    return right_servo


def pulsed(servo: PortCase, where: Collection[int], level: float, seed: int) -> Fitted:
    """Fitted twin that lacks a pulse in some of its recordings."""
    torques = []
    for k, states in enumerate(servo.states):
        inside = (states.time >= START) & (states.time < START + DURATION)
        torques.append(np.where(inside & (k in where), level, 0.0))
    return servo.with_torque(torques, seed)


def strongest(servo: PortCase, base: Fitted) -> Pulse | None:
    regression = Regression(servo.case.misfit, base)
    return strongest_pulse(servo.case, regression, servo.response, base.sensitivity)


def is_there(pulse: Pulse, within: float = 0.01) -> bool:
    end = pulse.start + pulse.duration
    return abs(pulse.start - START) < within and abs(end - START - DURATION) < within


@pytest.mark.parametrize("level", [0.1, -0.3])
def test_a_pulse_at_the_same_time_in_all_recordings_is_found_as_one(
    servo: PortCase, level: float
) -> None:
    pulse = strongest(servo, pulsed(servo, ALL, level, seed=1))
    assert pulse is not None
    assert pulse.record == EVERY
    assert is_there(pulse)
    assert pulse.gain > 10.0 * LEAST_PULSE_GAIN


@pytest.mark.parametrize("record", ALL)
def test_a_pulse_in_a_single_recording_is_found_in_that_one(servo: PortCase, record: int) -> None:
    pulse = strongest(servo, pulsed(servo, [record], 0.1, seed=2))
    assert pulse is not None
    assert pulse.record == record
    assert is_there(pulse)


def test_a_pulse_too_weak_for_one_recording_is_found_in_all_together(servo: PortCase) -> None:
    """Recordings add up: the gain of all is that of each, summed."""
    one = strongest(servo, pulsed(servo, [1], 0.03, seed=3))
    every = strongest(servo, pulsed(servo, ALL, 0.03, seed=3))
    assert every is not None
    assert every.record == EVERY
    assert one is None or one.gain < 0.6 * every.gain


def test_where_boxes_of_all_recordings_mislead_those_of_one_tell_when(
    servo: PortCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Boxes are summed without what parameters take of them, which is much of a slow loop's."""
    elsewhere = Pulse(EVERY, START + 0.15, 0.05, LEAST_PULSE_GAIN)
    monkeypatch.setattr(pulses, "_shared", lambda *given: elsewhere)
    pulse = strongest(servo, pulsed(servo, ALL, 0.1, seed=4))
    assert pulse is not None
    assert pulse.record == EVERY
    assert is_there(pulse)


def test_white_residuals_hold_no_pulse(servo: PortCase) -> None:
    """False alarms: at most one in 20 nulls."""
    found = [strongest(servo, servo.white(seed)) for seed in range(20)]
    assert sum(pulse is not None for pulse in found) <= 1


def test_a_pulse_of_one_recording_changes_no_other(servo: PortCase) -> None:
    one, every = (
        pulse_change(servo.case, servo.response, Pulse(record, START, DURATION, 0.0))
        for record in (0, EVERY)
    )
    for whitener, there, anywhere in zip(servo.case.misfit.whiteners, one, every, strict=True):
        if whitener.window.record == 0:
            np.testing.assert_array_equal(there, anywhere)
        else:
            assert not np.any(there)


@pytest.mark.slow
def test_a_pulse_that_the_physics_makes_in_each_recording_is_found_through_the_loop() -> None:
    physics = {"start": START, "duration": DURATION, "level": 0.1}
    case = open_servo({f"pulse_disturbance.{name}": value for name, value in physics.items()})
    hidden = port_case(case)
    lines = find_lines(case, case.base, hidden.response)
    case.simulations.close()
    (pulse,) = lines.passing
    assert pulse.record == EVERY
    assert is_there(pulse)
    assert lines.pulses == ((pulse.start, pulse.duration),)


@pytest.mark.slow
@pytest.mark.parametrize("where", [(0, 1), (1,)])
def test_a_pulse_is_named_with_its_size_in_the_recordings_that_have_it(
    where: tuple[int, ...],
) -> None:
    hidden = {"start": 0.9, "duration": 0.12, "level": 0.3}
    physics = {f"pulse_disturbance.{name}": value for name, value in hidden.items()}
    with_pulse, without = (SERVO.recordings(p, (multisine, moves)) for p in (physics, {}))
    recordings = [with_pulse[k] if k in where else without[k] for k in (0, 1)]
    only = ("pulse_disturbance", "coulomb_friction", "constant_torque_offset")
    diagnosis = diagnosed(SERVO.twin(), recordings, only=only)
    assert named(diagnosis) == ["pulse_disturbance"]
    values = diagnosis.effects[0].parameters
    for name, value in hidden.items():
        assert values[name].value == pytest.approx(value, rel=0.1)
