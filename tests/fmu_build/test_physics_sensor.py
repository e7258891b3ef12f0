"""Sensor effects and tracking of physics.fmu: readings, true positions, efforts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fmu_build.effect_sizes import SHOWING, parameters, port_of

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

STEP = 1e-3
SENSORS = [effect for effect in SHOWING if port_of(effect) == "sensor"]
T = np.arange(60, dtype=np.float64) * STEP
POSITION = 0.3 + np.sin(40.0 * T)


def error(
    new_instance: NewInstance, position: NDArray[np.float64], **values: float
) -> NDArray[np.float64]:
    """What is added to the reading of the position, shape of `position`."""
    effects = new_instance("physics").start(**values)
    return effects.run({"state.position": position}, ["sensor"], STEP)[1:, 0]


def test_each_error_is_its_formula(new_instance: NewInstance) -> None:
    disc = 0.01 * np.sin(2.0 * POSITION) + 0.02 * np.cos(2.0 * POSITION)
    expected = {
        "sensor_offset": np.full(60, 0.1),
        "sensor_scale": 0.01 * POSITION,
        "sensor_eccentricity": disc - disc[0],  # homed where the axis stood
    }
    for effect, column in expected.items():
        result = error(new_instance, POSITION, **parameters(effect))
        np.testing.assert_allclose(result, column, rtol=1e-12, err_msg=effect)


@pytest.mark.parametrize("time", [1e-7, 1e-3, 0.02])
def test_the_lag_of_a_ramp_is_exact(new_instance: NewInstance, time: float) -> None:
    """From rest at 1, slope 3: behind by 3 time (1 - exp(-t / time))."""
    result = error(new_instance, 1.0 + 3.0 * T, sensor_lag__time=time)
    np.testing.assert_allclose(result, 3.0 * time * np.expm1(-T / time), rtol=0.0, atol=1e-14)


def test_the_lag_of_a_sine_converges_with_second_order(new_instance: NewInstance) -> None:
    """q = cos(w t), started settled at 1: y is the sine's answer and what is left of its start."""
    rate, time = 2.0 * np.pi * 10.0, 5e-3
    gain = 1.0 / (1.0 + (rate * time) ** 2)
    errors = []
    for divisor in (1, 2, 4):
        step = STEP / divisor
        t = np.arange(50 * divisor + 1) * step
        effects = new_instance("physics").start(sensor_lag__time=time)
        table = effects.run({"state.position": np.cos(rate * t)}, ["sensor"], step)
        answer = gain * (np.cos(rate * t) + rate * time * np.sin(rate * t))
        exact = answer + (1.0 - gain) * np.exp(-t / time)
        errors.append(abs(table[-1, 0] + np.cos(rate * t[-1]) - exact[-1]))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(np.abs(orders - 2.0) < 0.2), orders


@pytest.mark.parametrize("effect", SENSORS)
def test_a_reading_that_holds_the_error_already_gives_the_same(
    new_instance: NewInstance, effect: str
) -> None:
    """tracking.sensor_included: state.position contains the sensor output of the step before."""
    expected = error(new_instance, POSITION, **parameters(effect))
    effects = new_instance("physics").start(**parameters(effect), tracking__sensor_included=1.0)
    result = np.empty(60)
    for k in range(60):
        effects.set(state__position=POSITION[k] + effects.get("sensor"))
        effects.step(k * STEP, STEP)
        result[k] = effects.get("sensor")
    np.testing.assert_allclose(result, expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("included", [0.0, 1.0])
def test_a_tracked_controller_reads_the_recording(
    new_instance: NewInstance, included: float
) -> None:
    """Whatever the twin does and whichever sensor errors are on: they are in the recording."""
    effects = new_instance("physics").start(
        tracking__sensor=1.0, tracking__sensor_included=included, **parameters("sensor_scale")
    )
    measured = np.cos(70.0 * T)
    for k in range(60):
        shown = POSITION[k] + included * effects.get("sensor")
        effects.set(state__position=shown, tracking__measured=measured[k])
        effects.step(k * STEP, STEP)
        assert POSITION[k] + effects.get("sensor") == pytest.approx(measured[k], abs=1e-14)


def test_the_effort_is_a_spring_and_a_damper_on_the_recording(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        tracking__kp=2.0, tracking__kd=0.03, constant_torque_offset__level=0.5, port__torque=0.25
    )
    measured = np.cos(70.0 * T)
    inputs = {"state.position": POSITION, "tracking.measured": measured}
    table = effects.run(inputs, ["tracking.effort", "torque"], STEP)[1:]
    difference = measured - POSITION
    effort = 2.0 * difference + 0.03 * np.diff(difference, prepend=difference[0]) / STEP
    np.testing.assert_allclose(table[:, 0], effort, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(table[:, 1], 0.75 + effort, rtol=1e-11, atol=1e-14)


def test_the_effort_of_a_held_mass_is_the_torque_that_it_lacks(new_instance: NewInstance) -> None:
    """A mass that should stand still under 0.2: the loop settles and reads -0.2."""
    effects = new_instance("physics").start(tracking__kp=5.0, tracking__kd=0.1)
    q = v = 0.0
    for k in range(2000):
        effects.set(state__position=q, state__velocity=v)
        effects.step(k * 1e-4, 1e-4)
        acceleration = (0.2 + effects.get("torque")) / 1e-3
        q, v = q + (v + 0.5 * acceleration * 1e-4) * 1e-4, v + acceleration * 1e-4
    assert effects.get("tracking.effort") == pytest.approx(-0.2, rel=1e-3)


def test_a_velocity_from_the_position_is_its_last_difference(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        viscous_friction__coefficient=1.0,
        settings__velocity_from_position=1.0,
        state__velocity=99.0,
    )
    torque = effects.run({"state.position": POSITION}, ["torque"], STEP)[1:, 0]
    np.testing.assert_allclose(
        torque, -np.diff(POSITION, prepend=POSITION[0]) / STEP, rtol=1e-11, atol=1e-12
    )


def test_a_start_away_from_zero_is_no_velocity(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        settings__velocity_from_position=1.0,
        viscous_friction__coefficient=1.0,
        load_inertia__inertia=1.0,
        tracking__kd=1.0,
        state__position=7.0,
    )
    assert np.all(effects.run({}, ["torque"], STEP, rows=5) == 0.0)
