"""Loads behind a gap or a spring: two masses by an independent solver, energy, momentum."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.fmu_build.shaft import ShaftRun, run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

SHAFT, LOAD, STIFFNESS, DAMPING, GAP, END = 1e-3, 5e-4, 200.0, 0.01, 0.01, 0.15
JOINTS = {"backlash": GAP, "torsional_compliance": 0.0}


def push(t: float) -> float:
    """Torque on the shaft: it goes through the gap several times."""
    return 0.05 * float(np.sin(2.0 * np.pi * 8.0 * t))


def joint_torque(joint: str, twist: float, rate: float) -> float:
    """Torque on the load; a flank pushes and never pulls."""
    if joint == "torsional_compliance":
        return STIFFNESS * twist + DAMPING * rate
    side, depth = np.sign(twist), abs(twist) - 0.5 * GAP
    if depth <= 0.0:
        return 0.0
    return float(side * max(0.0, STIFFNESS * depth + DAMPING * side * rate))


@cache
def two_masses(joint: str) -> NDArray[np.float64]:
    """Position and velocity of the shaft at the end, by a solver of eighth order."""

    def slope(t: float, y: NDArray[np.float64]) -> list[float]:
        torque = joint_torque(joint, y[0] - y[2], y[1] - y[3])
        return [y[1], (push(t) - torque) / SHAFT, y[3], torque / LOAD]

    solution = solve_ivp(
        slope, (0.0, END), np.zeros(4), method="DOP853", rtol=1e-9, atol=1e-12, max_step=2.5e-4
    )
    return np.asarray(solution.y[:2, -1])


def with_load(new_instance: NewInstance, joint: str, step: float) -> ShaftRun:
    """The shaft alone as the twin, the load in the effect."""
    values = {"stiffness": STIFFNESS, "damping": DAMPING, "load_inertia": LOAD}
    effects = new_instance("physics").start(**{f"{joint}.{k}": v for k, v in values.items()})
    effects.set(backlash__gap=GAP)
    return run_shaft(effects, SHAFT, step, END, drive=lambda t, q, v: push(t + 0.5 * step))


@pytest.mark.parametrize("joint", JOINTS)
def test_a_load_converges_to_the_two_mass_system(new_instance: NewInstance, joint: str) -> None:
    """Second order in the communication step (the kinks of the gap cost some of it)."""
    steps = (4e-4, 2e-4, 1e-4, 5e-5)
    errors = np.array(
        [abs(with_load(new_instance, joint, step).q[-1] - two_masses(joint)[0]) for step in steps]
    )
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 1.5), (errors, orders)
    assert errors[-1] < 1e-5 * 0.14  # of the range


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("hardness", [0.002, 0.02, 0.1])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_a_load_creates_no_energy(
    new_instance: NewInstance, joint: str, hardness: float, ratio: float
) -> None:
    """Without damping, over 2000 steps; hardness is stiffness step^2 / inertia of the shaft."""
    step, load = 1e-3, ratio * SHAFT
    values = {"stiffness": hardness * SHAFT / step**2, "load_inertia": load}
    effects = new_instance("physics").start(**{f"{joint}.{k}": v for k, v in values.items()})
    effects.set(backlash__gap=0.02)
    run = run_shaft(effects, SHAFT, step, 2000 * step, start=(0.0, 1.0))
    load_velocity = SHAFT * (1.0 - run.v) / load  # their momentum together is kept
    kinetic = SHAFT * run.v**2 + load * load_velocity**2
    assert kinetic.max() < 1.001 * SHAFT
    assert kinetic[-500:].max() > 0.99 * SHAFT / (1.0 + ratio)  # what the momentum keeps


def test_the_shaft_moves_freely_within_the_gap(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        backlash__gap=0.2, backlash__load_inertia=LOAD, backlash__stiffness=STIFFNESS
    )
    run = run_shaft(effects, SHAFT, 1e-3, 0.3, start=(5.0, 0.5))
    free = run.q[:-1] + 0.5 * 1e-3 < 5.1  # half the gap on either side
    assert free.sum() > 150
    np.testing.assert_array_equal(run.torque[free], 0.0)
    assert run.torque[~free].min() < 0.0


def test_an_elastic_flank_returns_all_of_a_blow(new_instance: NewInstance) -> None:
    """Equal masses exchange their velocities: the shaft stops, the load flies on."""
    effects = new_instance("physics").start(
        backlash__gap=0.01, backlash__load_inertia=SHAFT, backlash__stiffness=STIFFNESS
    )
    run = run_shaft(effects, SHAFT, 2e-5, 0.018, start=(0.0, 0.5))
    assert run.v[0] == 0.5
    assert abs(run.v[-1]) < 1e-5


def test_a_rigid_load_adds_its_inertia(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(
        torsional_compliance__load_inertia=LOAD,
        torsional_compliance__stiffness=1e4,
        torsional_compliance__damping=0.5,
    )
    run = run_shaft(effects, SHAFT, 1e-4, 0.2, drive=lambda t, q, v: 0.03)
    assert run.v[-1] == pytest.approx(0.03 / (SHAFT + LOAD) * 0.2, rel=1e-3)


@pytest.mark.parametrize("damping", [0.0, 1e-4, 0.0141421356237, 0.5])
def test_the_spring_is_exact_for_a_shaft_at_constant_speed(
    new_instance: NewInstance, damping: float
) -> None:
    """Undamped to overdamped: the torque is minus the load's change of momentum."""
    inertia, stiffness, speed, step = 5e-4, 0.1, 2.0, 1e-3
    effects = new_instance("physics").start(
        torsional_compliance__load_inertia=inertia,
        torsional_compliance__stiffness=stiffness,
        torsional_compliance__damping=damping,
    )
    t = np.arange(301, dtype=np.float64) * step
    table = effects.run(
        {"state.position": speed * t, "state.velocity": np.full(301, speed)},
        ["torque"],
        step,
        rows=300,
    )

    def slope(_: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], -(stiffness * y[0] + damping * y[1]) / inertia]

    solution = solve_ivp(
        slope, (0.0, t[-1]), [0.0, speed], t_eval=t, method="Radau", rtol=1e-10, atol=1e-12
    )
    expected = inertia * np.diff(solution.y[1]) / step
    np.testing.assert_allclose(table[1:, 0], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("ratio", [-0.4, 0.5, 3.0])
def test_load_inertia_acts_as_inertia(new_instance: NewInstance, ratio: float) -> None:
    """Stable to six times the twin's own, exact once the acceleration is steady."""
    effects = new_instance("physics").start(load_inertia__inertia=ratio * SHAFT)
    run = run_shaft(effects, SHAFT, 1e-3, 0.2, drive=lambda t, q, v: 0.03)
    acceleration = np.diff(run.v[-50:]) / 1e-3
    np.testing.assert_allclose(acceleration, 0.03 / (SHAFT * (1.0 + ratio)), rtol=1e-6)
