"""Steady states in closed form, energy, and an independent integration of the equations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from tests.drive_twin.drive_runs import (
    CORNERS,
    IDEAL_ENCODERS,
    NO_FRICTION,
    NO_RIPPLE,
    Drive,
)
from tests.drive_twin.flux_map import (
    INDUCTANCE_D,
    INDUCTANCE_Q,
    MAGNETS,
    formula,
    linear_table,
    magnetic_energy,
    map_deltas,
    nominal_table,
)

POLE_PAIRS, RATIO, RESISTANCE = 10, 9, 0.1
TORQUE_CONSTANT = 1.5 * POLE_PAIRS * RATIO * MAGNETS  # [N.m/A] at the joint
INERTIA = 0.14 + RATIO**2 * 2e-4  # [kg.m2]
LIGHT = {"load.inertia": 1e-4, "motor.inertia": 1e-5}
DRY = {"friction.coulomb": 1.2, "friction.stribeck": 0.3}
FREE = (0.0, 0.0)  # gains: the torque reference alone acts


def test_steady_speed_and_current_under_viscous_friction(drive: Drive) -> None:
    """At constant speed b w = tau, i_q = tau / k_t and v_q = R i_q + w_e psi_d."""
    torque, viscous = 2.0, 0.5
    parameters = {**LIGHT, **NO_RIPPLE, **IDEAL_ENCODERS, "friction.viscous": viscous}
    dry = {"friction.coulomb": 0.0, "friction.stribeck": 0.0}
    run = drive.run({**parameters, **dry}, gains=FREE, torque_reference=torque)
    last = {name: signal[-1] for name, signal in run.signals.items()}
    assert last["velocity"] == pytest.approx(torque / viscous, rel=1e-9)
    assert last["i_q"] == pytest.approx(torque / TORQUE_CONSTANT, rel=1e-9)
    assert last["i_d"] == pytest.approx(0.0, abs=1e-8)
    back_emf = POLE_PAIRS * RATIO * last["velocity"] * MAGNETS
    assert last["v_q"] == pytest.approx(RESISTANCE * last["i_q"] + back_emf, rel=1e-7)


@pytest.mark.parametrize("torque", [1.8, 2.0, 5.0])
def test_steady_speed_follows_the_stribeck_curve(drive: Drive, torque: float) -> None:
    """Solves tau = b w + F_c + F_s exp(-(w / w_s)^2) beyond the breakaway level."""
    viscous = 1.0
    parameters = {**LIGHT, **NO_RIPPLE, **DRY, "friction.viscous": viscous}
    pushed = {**parameters, "initial.velocity": 1.0}
    run = drive.run(pushed, gains=FREE, duration=2.0, torque_reference=torque)
    speed = brentq(
        lambda w: viscous * w + 1.2 + 0.3 * np.exp(-((w / 0.3) ** 2)) - torque, 0.4, 10.0
    )
    assert run.signal("velocity")[-1] == pytest.approx(speed, rel=1e-6)


def test_below_breakaway_the_joint_only_deflects(drive: Drive) -> None:
    """df/dq = (level / presliding) (1 - f / level): q = -presliding ln(1 - tau / level)."""
    level, presliding, torque = 1.5, 1e-3, 0.6
    parameters = {**DRY, **NO_RIPPLE, "friction.stribeck_velocity": 100.0, "friction.viscous": 20.0}
    ramp = torque * np.minimum(np.arange(4001) / 3000.0, 1.0)
    run = drive.run(parameters, gains=FREE, duration=4.0, torque_reference=ramp)
    expected = -presliding * np.log(1.0 - torque / level)
    assert run.signal("true_position")[-1] == pytest.approx(expected, rel=1e-4)
    assert run.signal("velocity")[-1] == pytest.approx(0.0, abs=1e-7)


def test_current_limit_bounds_the_torque(drive: Drive) -> None:
    parameters = {"drive.current_limit": 20.0, "load.inertia": 1000.0, **NO_RIPPLE}
    run = drive.run(parameters, gains=FREE, torque_reference=60.0)
    assert run.signal("i_q")[-1] == pytest.approx(20.0, rel=1e-4)
    assert run.signal("torque")[-1] == pytest.approx(20.0 * TORQUE_CONSTANT, rel=1e-4)


def test_voltage_limit_holds(drive: Drive) -> None:
    run = drive.run(gains=(200.0, 2.0), step=5e-5)
    amplitude = np.hypot(run.signal("v_d"), run.signal("v_q"))
    assert amplitude.max() <= 48.0 / np.sqrt(3.0) * (1.0 + 1e-12)
    assert amplitude.max() > 20.0


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_energy_is_kept_without_losses(drive: Drive, angle: float) -> None:
    """Electrical energy becomes kinetic, magnetic, cogging and lifting energy, to 1e-6 of it."""
    step, duration, unbalance, cogging, order = 5e-6, 0.06, 3.0, 0.5, 60
    parameters = {
        **NO_FRICTION,
        **IDEAL_ENCODERS,
        "motor.resistance": 0.0,
        "ripple.amplitude": 0.0,
        "cogging.amplitude[1]": cogging,
        "cogging.amplitude[2]": 0.0,
        "load.unbalance": unbalance,
        "load.unbalance_angle": angle,
        "ctl.delay": 0.0,
    }
    torque = 25.0 * np.sin(2.0 * np.pi * 20.0 * np.arange(round(duration / step) + 1) * step)
    run = drive.run(
        parameters, gains=FREE, duration=duration, step=step, torque_reference=torque, reference=0.0
    )
    # The voltage of a row is that of the step before it; currents are smooth within a step.
    currents = np.stack([run.signal("i_d"), run.signal("i_q")])
    mean = 0.5 * (currents[:, 1:] + currents[:, :-1])
    voltages = np.stack([run.signal("v_d"), run.signal("v_q")])[:, 1:]
    supplied = 1.5 * float(np.sum(voltages * mean)) * step
    speed, position = run.signal("velocity"), run.signal("true_position")
    kinetic = 0.5 * INERTIA * np.square(speed)
    weight = -unbalance * np.cos(position + angle)
    detent = cogging * np.cos(order * RATIO * position) / (order * RATIO)
    mechanical = kinetic + weight + detent

    def missing_current(flux: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(formula(flux[0], flux[1]) - currents[:, -1])

    flux = fsolve(missing_current, np.zeros(2), xtol=1e-13)
    stored = mechanical[-1] - mechanical[0] + 1.5 * magnetic_energy(flux[0], flux[1])
    assert supplied == pytest.approx(stored, abs=2e-6 * kinetic.max())


def reference_run(
    gains: tuple[float, float], duration: float, torque_limit: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Position and i_q each millisecond by another program: sampled loops around solve_ivp.

    Linear map, viscous friction, cogging and ripple; ideal encoders, no delay.
    """
    kp, kd = gains
    bandwidth, period = 2.0 * np.pi * 800.0, 5e-5
    limit, share = 48.0 / np.sqrt(3.0), -np.expm1(-1e-3 / 8e-3)

    def rates(_: float, x: NDArray[np.float64], v_d: float, v_q: float) -> list[float]:
        psi_d, psi_q, angle, speed = x
        i_d, i_q = (psi_d - MAGNETS) / INDUCTANCE_D, psi_q / INDUCTANCE_Q
        electrical = POLE_PAIRS * RATIO * speed
        torque = 1.5 * POLE_PAIRS * RATIO * (psi_d * i_q - psi_q * i_d)
        torque *= 1.0 + 0.01 * np.sin(6.0 * POLE_PAIRS * RATIO * angle)
        torque += 0.1 * np.sin(60.0 * RATIO * angle) + 0.03 * np.sin(120.0 * RATIO * angle + 0.7)
        return [
            v_d - RESISTANCE * i_d + electrical * psi_q,
            v_q - RESISTANCE * i_q - electrical * psi_d,
            speed,
            (torque - 0.15 * speed) / INERTIA,
        ]

    x = np.array([MAGNETS, 0.0, 0.0, 0.0])
    integral, velocity, last, rows = np.zeros(2), 0.0, 0.0, [(0.0, 0.0)]
    for _ in range(round(duration / 1e-3)):
        velocity += share * ((x[2] - last) / 1e-3 - velocity)
        last = x[2]
        command = np.clip(kp * (1.0 - x[2]) - kd * velocity, -torque_limit, torque_limit)
        for _ in range(20):
            current = np.array([(x[0] - MAGNETS) / INDUCTANCE_D, x[1] / INDUCTANCE_Q])
            error = np.array([0.0, command / TORQUE_CONSTANT]) - current
            electrical = POLE_PAIRS * RATIO * x[3]
            forward = electrical * np.array(
                [-INDUCTANCE_Q * current[1], INDUCTANCE_D * current[0] + MAGNETS]
            )
            gain = bandwidth * np.array([INDUCTANCE_D, INDUCTANCE_Q])
            wanted = gain * error + integral + forward
            voltage = wanted * min(1.0, limit / max(float(np.hypot(*wanted)), 1e-300))
            integral = integral + bandwidth * RESISTANCE * period * (
                error + (voltage - wanted) / gain
            )
            x = solve_ivp(rates, (0.0, period), x, args=tuple(voltage), rtol=1e-10, atol=1e-13).y[
                :, -1
            ]
        rows.append((x[2], x[1] / INDUCTANCE_Q))
    position, i_q = np.array(rows).T
    return position, i_q


@pytest.mark.parametrize("gains", [CORNERS[1], (100.0, 6.0)])
def test_another_integration_of_the_equations_agrees(
    drive: Drive, gains: tuple[float, float]
) -> None:
    parameters = {
        **IDEAL_ENCODERS,
        "friction.coulomb": 0.0,
        "friction.stribeck": 0.0,
        "ctl.delay": 0.0,
        "ctl.torque_limit": 30.0,
        **map_deltas(linear_table() - nominal_table()),
    }
    run = drive.run(parameters, gains=gains, duration=0.03, reference=1.0)
    position, i_q = reference_run(gains, 0.03, 30.0)
    np.testing.assert_allclose(run.signal("true_position"), position, atol=1e-8)
    # The FMU counts the table in nA.
    np.testing.assert_allclose(run.signal("i_q"), i_q, atol=1e-6)
