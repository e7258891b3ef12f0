"""Servo with a pendulum: firmware law, motor and gravity, by oracles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from tests.fmu_build.fmu_instance import FmuInstance

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

COUNTS, GAIN_DIVISOR, FULL_DUTY = 4096, 256, 885  # of the servo's firmware
SUPPLY, KP, KT, R, ARMATURE = 7.4, 400.0, 0.354, 3.4, 0.0018
MASS, LENGTH, TILT, VISCOUS, GRAVITY = 0.49, 0.1, 0.03, 0.005, 9.80665
INERTIA = ARMATURE + MASS * LENGTH**2
STEP = 1e-3
SWING = {"enabled": 0.0, "viscous": 0.0, "motor__armature": 0.0}


def slope(time: float, state: NDArray[np.float64], voltage: float, load: float) -> list[float]:
    """Rates of position and velocity as the model's comment states them."""
    position, velocity = state
    motor = KT * (voltage - KT * velocity) / R
    gravity = MASS * GRAVITY * LENGTH * np.sin(position + TILT)
    return [velocity, (motor + load - gravity - VISCOUS * velocity) / INERTIA]


def test_the_servo_is_its_equations_in_closed_loop(new_instance: NewInstance) -> None:
    """A step into the limit of the duty and a sine, with a torque at the port."""
    k = np.arange(300)
    reference = 1.2 * (k > 20) + 0.3 * np.sin(0.03 * k)
    load = 0.05 * (k > 150)
    state, rows = np.zeros(2), [[0.0, 0.0, 0.0]]
    for wanted, torque in zip(reference, load, strict=True):
        pwm = (wanted - state[0]) * COUNTS / (2.0 * np.pi) * KP / GAIN_DIVISOR
        duty = float(np.clip(pwm / FULL_DUTY, -1.0, 1.0))
        solution = solve_ivp(
            slope, (0.0, STEP), state, args=(SUPPLY * duty, torque), rtol=1e-12, atol=1e-14
        )
        state = solution.y[:, -1]
        rows.append([*state, duty])
    written = np.array(rows)
    servo = new_instance("servo_pendulum").start(load__tilt=TILT)
    inputs = {"reference": reference, "port__torque": load}
    simulated = servo.run(inputs, ["true_position", "velocity", "duty"], STEP)
    assert np.max(np.abs(written[:, 2])) == 1.0  # the limit is part of the comparison
    np.testing.assert_allclose(simulated, written, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("amplitude", [1e-3, 0.5, 2.5])
def test_a_free_pendulum_has_the_period_of_the_elliptic_integral(
    new_instance: NewInstance, amplitude: float
) -> None:
    """T = 4 sqrt(l/g) K(sin^2(a/2)), which tends to 2 pi sqrt(l/g): after a period it is back."""
    natural = np.sqrt(LENGTH / GRAVITY)
    period = 4.0 * natural * float(ellipk(np.sin(0.5 * amplitude) ** 2))
    if amplitude < 0.01:
        assert period == pytest.approx(2.0 * np.pi * natural, rel=1e-6)
    pendulum = new_instance("servo_pendulum").start(initial_position=amplitude, **SWING)
    pendulum.step(0.0, 0.25 * period)
    assert pendulum.get("true_position") == pytest.approx(0.0, abs=1e-7 * amplitude)
    pendulum.step(0.25 * period, 0.75 * period)
    assert pendulum.get("true_position") == pytest.approx(amplitude, rel=1e-8)


def test_without_friction_the_energy_of_a_swing_is_kept(new_instance: NewInstance) -> None:
    pendulum = new_instance("servo_pendulum").start(
        enabled=0.0, viscous=0.0, initial_position=1.9, initial_velocity=3.0, load__tilt=TILT
    )
    table = pendulum.run({}, ["true_position", "velocity"], 1e-2, rows=500)
    kinetic = 0.5 * INERTIA * table[:, 1] ** 2
    potential = -MASS * GRAVITY * LENGTH * np.cos(table[:, 0] + TILT)
    assert np.ptp(kinetic) > 0.1
    np.testing.assert_allclose(kinetic + potential, kinetic[0] + potential[0], atol=1e-8)


def test_the_integration_is_of_fourth_order(new_instance: NewInstance) -> None:
    """Communication steps below the internal one are the steps of the integration."""

    def after(step: float) -> float:
        fast = {"motor__armature": 0.0, "load__mass": 0.01, "load__length": 0.02}
        pendulum = new_instance("servo_pendulum").start(
            enabled=0.0, viscous=0.0, initial_position=2.0, **fast
        )
        return float(pendulum.run({}, ["velocity"], step, rows=round(0.2 / step))[-1, 0])

    exact = solve_ivp(
        lambda t, y: [y[1], -GRAVITY / 0.02 * np.sin(y[0])],
        (0.0, 0.2),
        [2.0, 0.0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
    ).y[1, -1]
    errors = [abs(after(step) - exact) for step in (1e-3, 5e-4, 2.5e-4)]
    orders = np.log2(errors[:-1]) - np.log2(errors[1:])
    np.testing.assert_allclose(orders, 4.0, atol=0.3)


def test_without_gravity_the_motor_runs_up_against_its_back_emf(new_instance: NewInstance) -> None:
    """w(t) = V/kt (1 - exp(-t kt^2 / (R J))) at full duty and without friction."""
    motor = new_instance("servo_pendulum").start(
        reference=1e6, viscous=0.0, load__mass=0.0, supply=5.0
    )
    table = motor.run({}, ["velocity", "voltage", "motor_torque"], STEP, rows=400)
    time = np.arange(401) * STEP
    final, rate = 5.0 / KT, KT**2 / (R * ARMATURE)
    np.testing.assert_allclose(table[:, 0], final * -np.expm1(-rate * time), atol=1e-8)
    np.testing.assert_array_equal(table[1:, 1], 5.0)
    np.testing.assert_allclose(table[1:, 2], KT * (5.0 - KT * table[1:, 0]) / R, atol=1e-12)


def test_at_rest_motor_and_load_torque_hold_the_pendulum(new_instance: NewInstance) -> None:
    servo = new_instance("servo_pendulum").start(reference=1.0, servo__kp=200.0)
    for k in range(400):
        servo.step(k * 0.02, 0.02)
    holding = MASS * GRAVITY * LENGTH * np.sin(servo.get("true_position"))
    assert holding > 0.1
    for name in ("motor_torque", "gravity_torque", "load_torque"):
        assert servo.get(name) == pytest.approx(holding, rel=1e-6)


def test_an_open_bridge_carries_no_torque(new_instance: NewInstance) -> None:
    servo = new_instance("servo_pendulum").start(reference=1.0, enabled=0.0)
    servo.set(port__command=2.0)
    servo.step(0.0, 0.1)
    assert [servo.get(n) for n in ("duty", "voltage", "motor_torque", "velocity")] == [0.0] * 4


def test_each_port_of_the_pendulum_adds_to_its_signal(new_instance: NewInstance) -> None:
    """The sensor port reaches law and reading, the command port acts behind the limit."""
    servo = new_instance("servo_pendulum").start(initial_position=0.2, port__sensor=5.0)
    assert servo.get("position") == pytest.approx(5.2, abs=1e-15)
    assert servo.get("true_position") == 0.2
    servo.set(port__command=-1.5)
    servo.step(0.0, 1e-6)
    assert servo.get("duty") == -1.0
    assert servo.get("voltage") == -SUPPLY
    assert servo.get("motor_torque") == pytest.approx(KT * (-SUPPLY - 1.5) / R, rel=1e-4)


@settings(max_examples=20, deadline=None)
@given(
    gain=st.floats(0.0, 2000.0),
    goal=st.floats(-3.0, 3.0),
    tilt=st.floats(-1.0, 1.0),
    supply=st.floats(0.0, 20.0),
)
def test_the_mirrored_servo_moves_the_other_way(
    unpacked: Callable[[str], Path], gain: float, goal: float, tilt: float, supply: float
) -> None:
    end = []
    for sign in (1.0, -1.0):
        servo = FmuInstance(unpacked("servo_pendulum"))
        servo.start(reference=sign * goal, load__tilt=sign * tilt, servo__kp=gain, supply=supply)
        end.append(servo.run({}, ["position", "velocity", "duty"], 5e-3, rows=40))
        servo.close()
    np.testing.assert_allclose(end[0], -end[1], atol=1e-12)


def test_a_pendulum_without_any_inertia_is_refused(new_instance: NewInstance) -> None:
    servo = new_instance("servo_pendulum")
    with pytest.raises(FMICallException, match="fmi2ExitInitializationMode"):
        servo.start(motor__armature=0.0, load__mass=0.0)
    assert "nothing turns: set 'motor.armature'" in servo.messages[-1]


def test_divergence_of_the_pendulum_is_reported_in_words(new_instance: NewInstance) -> None:
    servo = new_instance("servo_pendulum").start(port__torque=1e307)
    with pytest.raises(RuntimeError, match="the pendulum has diverged"):
        servo.run({}, ["velocity"], 0.1, rows=100)
