"""The plant of the demo: the servo axis with its physics off, and each law by oracles."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

Array = NDArray[np.float64]
Law = Callable[[float, float, float], float]

INERTIA, VISCOUS, LAG, STEP = 0.01, 0.05, 5e-4, 1e-3
KP, KD, FILTER = 40.0, 0.8, 1e-3
IDEAL = {"encoder.counts": 0.0, "encoder.noise": 0.0}


def reference(rows: int = 400) -> Array:
    k = np.arange(rows)
    return np.asarray(0.6 * np.sin(0.02 * k) + 0.3 * (k > 100))


def plant(new_instance: NewInstance, parameters: dict[str, float], asked: Array) -> Array:
    """Position, velocity and command at the end of each step, shape (rows + 1, 3)."""
    given = {name.replace(".", "__"): value for name, value in {**IDEAL, **parameters}.items()}
    axis = new_instance("demo_axis").start(**given)
    return axis.run({"reference": asked}, ["true_position", "velocity", "torque_command"], STEP)


def in_closed_loop(torque: Law, asked: Array, lag: float = 0.0) -> Array:
    """The same by `solve_ivp` around the documented control law, with a torque on the shaft."""
    state, filtered, previous = np.zeros(4), 0.0, 0.0
    rows = [[0.0, 0.0, 0.0]]

    def slope(t: float, y: Array, u: float) -> list[float]:
        passed = y[3] if lag else u
        return [
            y[1],
            (y[2] - VISCOUS * y[1] + torque(t, y[0], y[1])) / INERTIA,
            (passed - y[2]) / LAG,
            (u - y[3]) / lag if lag else 0.0,
        ]

    for k, wanted in enumerate(asked):
        filtered = (FILTER * filtered + (state[0] - previous)) / (FILTER + STEP)
        previous = state[0]
        command = float(np.clip(KP * (wanted - state[0]) - KD * filtered, -10.0, 10.0))
        state = solve_ivp(
            slope,
            (k * STEP, (k + 1) * STEP),
            state,
            args=(command,),
            method="DOP853",
            rtol=1e-11,
            atol=1e-13,
        ).y[:, -1]
        rows.append([state[0], state[1], command])
    return np.array(rows)


def test_with_its_physics_off_the_plant_is_the_servo_axis(new_instance: NewInstance) -> None:
    asked = reference()
    twin = new_instance("servo_axis").start()
    known = twin.run({"reference": asked}, ["true_position", "velocity", "torque_command"], STEP)
    np.testing.assert_allclose(plant(new_instance, {}, asked), known, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("parameters", "torque"),
    [
        ({"drag": 0.01}, lambda t, q, w: -0.01 * w * abs(w)),
        (
            {"ripple.torque": 0.3, "ripple.cycles": 9.0, "ripple.phase": 0.7},
            lambda t, q, w: 0.3 * np.sin(9.0 * q + 0.7),
        ),
        ({"arm.torque": 0.8, "arm.angle": 1.0}, lambda t, q, w: -0.8 * np.sin(q - 1.0)),
        ({"spring.stiffness": 0.9, "spring.rest": 0.4}, lambda t, q, w: -0.9 * (q - 0.4)),
        ({"push": -0.5}, lambda t, q, w: -0.5),
        (
            {"hum.torque": 0.3, "hum.frequency": 17.0, "hum.phase": 0.5},
            lambda t, q, w: 0.3 * np.sin(2.0 * np.pi * 17.0 * t + 0.5),
        ),
    ],
    ids=["drag", "ripple", "arm", "spring", "push", "hum"],
)
def test_a_smooth_torque_is_its_equation_in_closed_loop(
    new_instance: NewInstance, parameters: dict[str, float], torque: Law
) -> None:
    asked = reference(250)
    simulated, exact = plant(new_instance, parameters, asked), in_closed_loop(torque, asked)
    assert np.max(np.abs(exact - in_closed_loop(lambda t, q, w: 0.0, asked))) > 1e-3
    np.testing.assert_allclose(simulated, exact, rtol=0.0, atol=2e-6)


def test_the_lag_of_the_drive_is_a_first_order_lag(new_instance: NewInstance) -> None:
    asked = reference(250)
    simulated = plant(new_instance, {"drive.lag": 2e-3}, asked)
    exact = in_closed_loop(lambda t, q, w: 0.0, asked, lag=2e-3)
    np.testing.assert_allclose(simulated, exact, rtol=0.0, atol=1e-6)


def test_a_stiff_belt_is_a_rigid_axis_and_a_soft_one_swings_at_its_own_frequency(
    new_instance: NewInstance,
) -> None:
    """With little motor damping a load behind a belt rings at sqrt(k (1/J_m + 1/J_l))."""
    asked = reference(300)
    rigid = plant(new_instance, {}, asked)
    stiff = {"load.inertia": 0.004, "belt.stiffness": 1e5, "belt.damping": 5.0}
    np.testing.assert_allclose(
        plant(new_instance, stiff, asked)[:, 0], rigid[:, 0], rtol=0.0, atol=2e-4
    )
    soft = {"load.inertia": 0.004, "belt.stiffness": 100.0, "viscous": 0.0, "kp": 0.0, "kd": 0.0}
    kicked = plant(new_instance, {**soft, "push": 0.05}, np.zeros(4000))
    time = STEP * np.arange(4001)
    swing = kicked[:, 1] - np.polyval(np.polyfit(time, kicked[:, 1], 1), time)
    spectrum = np.abs(np.fft.rfft(swing * np.hanning(swing.size)))
    peak = 2.0 * np.pi * np.fft.rfftfreq(swing.size, STEP)[np.argmax(spectrum)]
    expected = np.sqrt(100.0 * (1.0 / 0.006 + 1.0 / 0.004))
    assert peak == pytest.approx(expected, abs=2.0 * np.pi / time[-1])


def test_a_motor_in_its_gap_feels_its_own_inertia_alone(new_instance: NewInstance) -> None:
    """Pushed from the middle, it crosses half of the gap as if no load were there."""
    free = {"viscous": 0.0, "kp": 0.0, "kd": 0.0, "push": 0.1, "load.inertia": 0.004, "gap": 0.02}
    run = plant(new_instance, free, np.zeros(60))
    time = STEP * np.arange(61)
    alone = 0.5 * 0.1 / 0.006 * time**2
    inside = alone < 0.0099
    np.testing.assert_allclose(run[inside, 0], alone[inside], rtol=0.0, atol=1e-12)
    assert run[-1, 0] < 0.9 * alone[-1]  # then the load is in the way


def test_contact_loses_energy_and_momentum_is_kept(new_instance: NewInstance) -> None:
    """After a blow and without a push, motor and load drift with their common momentum."""
    free = {"viscous": 0.0, "kp": 0.0, "kd": 0.0, "load.inertia": 0.004, "gap": 0.01}
    axis = new_instance("demo_axis").start(
        **{name.replace(".", "__"): value for name, value in {**IDEAL, **free}.items()}, push=0.2
    )
    for k in range(20):  # before the contact: 0.005 rad take 17 ms
        axis.step(k * STEP, STEP)
    axis.set(push=0.0)
    velocities = []
    for k in range(20, 4000):
        axis.step(k * STEP, STEP)
        velocities.append(axis.get("velocity"))
    common = 0.2 * 0.020 / 0.01
    assert np.mean(velocities[-2000:]) == pytest.approx(common, rel=0.05)
    assert np.ptp(velocities[-500:]) < 0.5 * np.ptp(velocities[:500])


def test_friction_holds_the_axis_until_the_torque_passes_breakaway(
    new_instance: NewInstance,
) -> None:
    """A slow ramp of the reference: the surface does not move at all before."""
    rub = {
        "friction.forward": 0.3,
        "friction.backward": 0.3,
        "friction.breakaway": 0.1,
        "friction.stribeck_velocity": 0.5,
    }
    ramp = 0.1 * STEP * np.arange(300, dtype=np.float64)
    run = plant(new_instance, rub, ramp)
    starts = int(np.argmax(run[:, 0] > 0.0))
    assert np.all(run[:starts, 0] == 0.0)
    assert run[starts, 2] == pytest.approx(0.4, abs=0.005)


@pytest.mark.parametrize(("direction", "level"), [(1.0, 0.2), (-1.0, 0.35)])
def test_a_sliding_surface_comes_to_rest_in_finite_time(
    new_instance: NewInstance, direction: float, level: float
) -> None:
    """Without control, v(t) = v0 - F/J t until it is zero, and exactly zero from then on."""
    parameters = {"friction.forward": 0.2, "friction.backward": 0.35, "viscous": 0.0}
    given = {name.replace(".", "__"): value for name, value in {**IDEAL, **parameters}.items()}
    axis = new_instance("demo_axis").start(**given, kp=0.0, kd=0.0, push=2.0 * direction)
    for k in range(20):
        axis.step(k * STEP, STEP)
    begin = abs(axis.get("velocity"))
    assert begin == pytest.approx((2.0 - level) * 0.02 / INERTIA, rel=1e-9)
    axis.set(push=0.0)
    rest = begin * INERTIA / level
    speeds = []
    for k in range(20, 20 + int(rest / STEP) + 10):
        axis.step(k * STEP, STEP)
        speeds.append(abs(axis.get("velocity")))
    sliding = int(rest / STEP)
    exact = begin - level / INERTIA * STEP * np.arange(1, sliding + 1)
    np.testing.assert_allclose(speeds[:sliding], exact, rtol=0.0, atol=1e-9)
    assert speeds[sliding + 1 :] == [0.0] * len(speeds[sliding + 1 :])


@pytest.mark.parametrize("delay", [1.37e-3, 4e-3])
def test_a_delayed_command_arrives_late_by_the_delay(
    new_instance: NewInstance, delay: float
) -> None:
    """A delayed step gives the same response, later; off the grid by the fraction of a step."""
    open_loop = {"kp": 1.0, "kd": 0.0, "inertia": 100.0, "viscous": 0.0}
    step = np.ones(30)
    late = plant(new_instance, {**open_loop, "drive.delay": delay}, step)[:, 1]
    time = STEP * np.arange(31) - delay
    exact = np.where(time > 0.0, (time - LAG * (1.0 - np.exp(-time / LAG))) / 100.0, 0.0)
    np.testing.assert_allclose(late, exact, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("parameters", "passed"),
    [
        ({"drive.dead_zone": 0.4}, 0.6),
        ({"drive.dead_zone": 1.2}, 0.0),
        ({"drive.limit": 0.7}, 0.7),
        ({"drive.limit": 0.7, "drive.dead_zone": 0.4}, 0.6),
    ],
)
def test_the_drive_passes_a_command_of_one_on_as_it_is_limited(
    new_instance: NewInstance, parameters: dict[str, float], passed: float
) -> None:
    given = {name.replace(".", "__"): value for name, value in parameters.items()}
    axis = new_instance("demo_axis").start(
        **given, kp=1.0, kd=0.0, inertia=100.0, reference=1.0, encoder__noise=0.0
    )
    for k in range(20):
        axis.step(k * STEP, STEP)
    assert axis.get("torque") == pytest.approx(passed, abs=1e-4)


def test_the_encoder_counts_and_its_noise_belongs_to_the_sample(
    new_instance: NewInstance,
) -> None:
    """White noise of the stated size beside the counts; another seed, other noise."""
    held = {"kp": 0.0, "kd": 0.0, "encoder__counts": 1e9, "encoder__noise": 1e-3}
    columns = []
    for seed in (1.0, 1.0, 2.0):
        axis = new_instance("demo_axis").start(**held, encoder__seed=seed)
        columns.append(axis.run({"reference": np.zeros(3000)}, ["position"], STEP)[1:, 0])
    first, again, other = columns
    np.testing.assert_array_equal(first, again)
    # Five standard errors of each statistic of 3000 normal numbers: false alarm 1 in 10^6.
    assert np.std(first) == pytest.approx(1e-3, rel=5.0 / np.sqrt(2.0 * 3000))
    assert abs(np.mean(first)) < 5.0 * 1e-3 / np.sqrt(3000)
    assert abs(np.corrcoef(first[1:], first[:-1])[0, 1]) < 5.0 / np.sqrt(3000)
    assert abs(np.corrcoef(first, other)[0, 1]) < 5.0 / np.sqrt(3000)
    coarse = new_instance("demo_axis").start(encoder__counts=100.0, initial_position=0.1)
    assert coarse.get("position") == pytest.approx(2.0 * np.pi / 100.0 * 2.0)


@pytest.mark.parametrize(
    ("parameters", "complaint"),
    [
        ({"load__inertia": 0.02}, "'load.inertia' is part of 'inertia'"),
        ({"drive__delay": 0.5}, "'drive.delay' is longer than 126 samples"),
        ({"drive__lag": 1e-6}, "'drive.lag' is shorter than the inner step"),
    ],
)
def test_values_that_contradict_each_other_are_refused(
    new_instance: NewInstance, parameters: dict[str, float], complaint: str
) -> None:
    axis = new_instance("demo_axis")
    with pytest.raises(FMICallException, match="fmi2ExitInitializationMode failed"):
        axis.start(**parameters)
    assert complaint in "".join(axis.messages)
