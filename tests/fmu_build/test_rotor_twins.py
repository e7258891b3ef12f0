"""Servo axis and motor bench: their exact integrator and controller, by oracles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

INERTIA, VISCOUS, LAG, LIMIT = 0.01, 0.05, 5e-4, 10.0
KP, KD, FILTER, STEP = 40.0, 0.8, 1e-3, 1e-3
BENCH_INERTIA, CONSTANT, BENCH_VISCOUS = 0.005, 0.5, 0.02


def servo_in_closed_loop(reference: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of position, velocity, torque and command: the documented law around `solve_ivp`."""
    state, filtered, previous = np.zeros(3), 0.0, 0.0
    rows = [[0.0, 0.0, 0.0, 0.0]]
    for k, wanted in enumerate(reference):
        filtered = (FILTER * filtered + (state[0] - previous)) / (FILTER + STEP)
        previous = state[0]
        command = float(np.clip(KP * (wanted - state[0]) - KD * filtered, -LIMIT, LIMIT))
        state = solve_ivp(
            lambda t, y, u: [y[1], (y[2] - VISCOUS * y[1]) / INERTIA, (u - y[2]) / LAG],
            (k * STEP, (k + 1) * STEP),
            state,
            args=(command,),
            method="DOP853",
            rtol=1e-12,
            atol=1e-14,
        ).y[:, -1]
        rows.append([*state, command])
    return np.array(rows)


def test_the_servo_is_its_equations_in_closed_loop(new_instance: NewInstance) -> None:
    """A step into the torque limit and a sine."""
    k = np.arange(250)
    reference = 0.5 * (k > 20) + 0.1 * np.sin(0.05 * k)
    written = servo_in_closed_loop(reference)
    simulated = (
        new_instance("servo_axis")
        .start()
        .run(
            {"reference": reference},
            ["true_position", "velocity", "torque", "torque_command"],
            STEP,
        )
    )
    assert np.max(np.abs(written[:, 3])) == LIMIT  # the limit is part of the comparison
    np.testing.assert_allclose(simulated[:, 0], written[:, 0], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(simulated[:, 1:], written[:, 1:], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("lag", [1e-5, 5e-4, 0.2])
@pytest.mark.parametrize("viscous", [0.0, 0.05, 100.0])
def test_a_step_of_the_servo_is_the_matrix_exponential(
    new_instance: NewInstance, lag: float, viscous: float
) -> None:
    """Slow and stiff, integrators and equal time constants: exact by other means."""
    load, command, h = 0.3, -0.7, 1e-3
    axis = new_instance("servo_axis").start(
        kp=0.0, kd=0.0, viscous=viscous, torque_lag=lag, tau_load=load, tau_command=command
    )
    matrix = np.zeros((4, 4))
    matrix[0, 1] = 1.0
    matrix[1] = [0.0, -viscous / INERTIA, 1.0 / INERTIA, load / INERTIA]
    matrix[2, 2:] = [-1.0 / lag, command / lag]
    exact = np.array([0.0, 0.0, 0.0, 1.0])
    for step in range(5):
        axis.step(step * h, h)
        exact = expm(matrix * h) @ exact
    there = [axis.get(name) for name in ("true_position", "velocity", "torque")]
    np.testing.assert_allclose(there, exact[:3], rtol=1e-10, atol=1e-14)


def test_the_servo_does_not_depend_on_the_communication_step(new_instance: NewInstance) -> None:
    reference = np.repeat(0.2 * np.sin(0.02 * np.arange(120)), 10)
    fine = new_instance("servo_axis").start()
    coarse = new_instance("servo_axis").start()
    names = ["true_position", "velocity", "torque_command"]
    every = fine.run({"reference": reference}, names, STEP / 10)[::10]
    seldom = coarse.run({"reference": reference[::10]}, names, STEP)
    np.testing.assert_allclose(every, seldom, rtol=0.0, atol=1e-11)


def test_each_port_of_the_servo_adds_to_its_signal(new_instance: NewInstance) -> None:
    """The sensor port reaches controller and reading, the command port acts behind the limit."""
    axis = new_instance("servo_axis").start(initial_position=0.2, encoder_offset=1.0)
    assert axis.get("position") == pytest.approx(1.2, abs=1e-15)
    assert axis.get("true_position") == 0.2
    axis.set(reference=0.2, tau_command=2.5, tau_load=0.5)
    axis.step(0.0, STEP)
    assert axis.get("torque_command") == -LIMIT  # kp of 1 rad is 40 N.m, beyond the limit
    reached = 1.0 - np.exp(-STEP / LAG)
    assert axis.get("torque") == pytest.approx((2.5 - LIMIT) * reached, rel=1e-12)


def test_the_bench_follows_the_closed_form(new_instance: NewInstance) -> None:
    """w(t) = T/b (1 - exp(-t b/J)) under a constant current and load."""
    bench = new_instance("motor_bench").start(current=0.4, tau_load=-0.05)
    table = bench.run({}, ["position", "velocity", "motor_current"], 1e-3, rows=400)
    t = np.arange(401) * 1e-3
    rate, torque = BENCH_VISCOUS / BENCH_INERTIA, CONSTANT * 0.4 - 0.05
    velocity = torque / BENCH_VISCOUS * (1.0 - np.exp(-rate * t))
    position = torque / BENCH_VISCOUS * (t - (1.0 - np.exp(-rate * t)) / rate)
    np.testing.assert_allclose(table[:, 0], position, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(table[:, 1], velocity, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(table[1:, 2], 0.4)


def test_the_bench_logs_its_current_behind_a_first_order_filter(new_instance: NewInstance) -> None:
    """A step of current: 1 - exp(-t/T) from where the filter stood; without one, the current."""
    t = np.arange(401) * 1e-3
    for log_time, expected in ((0.125, 2.0 - 1.5 * np.exp(-t / 0.125)), (0.0, 2.0 + 0.0 * t)):
        bench = new_instance("motor_bench").start(
            current=2.0, log_time=log_time, initial_logged_current=0.5
        )
        table = bench.run({}, ["logged_current"], 1e-3, rows=400)
        np.testing.assert_allclose(table[1:, 0], expected[1:], rtol=0.0, atol=1e-13)
        assert table[0, 0] == 0.5


def test_without_friction_the_bench_is_a_double_integrator(new_instance: NewInstance) -> None:
    bench = new_instance("motor_bench").start(
        viscous=0.0, current=1.0, initial_position=0.1, initial_velocity=-2.0
    )
    bench.step(0.0, 0.5)
    acceleration = CONSTANT / BENCH_INERTIA
    assert bench.get("velocity") == pytest.approx(-2.0 + 0.5 * acceleration, rel=1e-13)
    assert bench.get("position") == pytest.approx(0.1 - 1.0 + 0.125 * acceleration, rel=1e-13)


@pytest.mark.parametrize("model", ["servo_axis", "motor_bench"])
def test_divergence_of_a_rotor_is_reported_in_words(new_instance: NewInstance, model: str) -> None:
    rotor = new_instance(model).start(tau_load=1e307)
    with pytest.raises(RuntimeError, match="has diverged"):
        rotor.run({}, ["velocity"], 1.0, rows=100)
