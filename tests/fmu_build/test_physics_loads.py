"""Loads behind a gap or a spring: two masses by an independent solver, energy, momentum."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.fmu_build.shaft import Drive, ShaftRun, run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance
    from tests.fmu_build.fmu_instance import FmuInstance

SHAFT, LOAD, STIFFNESS, DAMPING, GAP, END = 1e-3, 5e-4, 200.0, 0.01, 0.01, 0.15
JOINTS = {"backlash": GAP, "torsional_compliance": 0.0}


def push(t: float) -> float:
    """Torque on the shaft: it goes through the gap several times."""
    return 0.05 * float(np.sin(2.0 * np.pi * 8.0 * t))


def pushed(step: float) -> Drive:
    """The push in the middle of each step."""
    return lambda t, q, v: push(t + 0.5 * step)


@cache
def two_masses(
    joint: str, stiffness: float = STIFFNESS, damping: float = DAMPING
) -> NDArray[np.float64]:
    """Position of the shaft at every ms, by a solver of eighth order."""

    def torque(twist: float, rate: float) -> float:
        """On the load; a flank pushes and never pulls."""
        if joint == "torsional_compliance":
            return stiffness * twist + damping * rate
        side, depth = np.sign(twist), abs(twist) - 0.5 * GAP
        if depth <= 0.0:
            return 0.0
        return float(side * max(0.0, stiffness * depth + damping * side * rate))

    def slope(t: float, y: NDArray[np.float64]) -> list[float]:
        passed = torque(y[0] - y[2], y[1] - y[3])
        return [y[1], (push(t) - passed) / SHAFT, y[3], passed / LOAD]

    times = np.arange(round(END / 1e-3) + 1) * 1e-3
    solution = solve_ivp(
        slope, (0.0, END), np.zeros(4), "DOP853", times, rtol=1e-9, atol=1e-12, max_step=2e-5
    )
    return np.asarray(solution.y[0])


def effect_of(
    new_instance: NewInstance,
    joint: str,
    stiffness: float,
    damping: float = 0.0,
    load: float = LOAD,
    *,
    shaft: float = 0.0,
    gap: float = GAP,
) -> FmuInstance:
    """A load behind a joint; `shaft` is the inertia that the effect is told of, 0 for none."""
    values = {"stiffness": stiffness, "damping": damping, "load_inertia": load}
    values["shaft_inertia"] = shaft
    effects = new_instance("physics").start(**{f"{joint}.{k}": v for k, v in values.items()})
    effects.set(backlash__gap=gap)
    return effects


def with_load(new_instance: NewInstance, joint: str, step: float, shaft: float = 0.0) -> ShaftRun:
    """The shaft alone as the twin, the load in the effect."""
    effects = effect_of(new_instance, joint, STIFFNESS, DAMPING, shaft=shaft)
    return run_shaft(effects, SHAFT, step, END, drive=pushed(step))


def assert_no_energy_is_created(effects: FmuInstance, ratio: float, step: float) -> None:
    """Without damping, over 2000 steps."""
    load = ratio * SHAFT
    run = run_shaft(effects, SHAFT, step, 2000 * step, start=(0.0, 1.0))
    load_velocity = SHAFT * (1.0 - run.v) / load  # their momentum together is kept
    kinetic = SHAFT * run.v**2 + load * load_velocity**2
    assert kinetic.max() < 1.001 * SHAFT
    assert kinetic[-500:].max() > 0.99 * SHAFT / (1.0 + ratio)  # what the momentum keeps


@pytest.mark.parametrize("joint", JOINTS)
def test_a_load_converges_to_the_two_mass_system(new_instance: NewInstance, joint: str) -> None:
    """Second order in the communication step (the kinks of the gap cost some of it)."""
    steps = (4e-4, 2e-4, 1e-4, 5e-5)
    errors = np.array(
        [abs(with_load(new_instance, joint, step).q[-1] - two_masses(joint)[-1]) for step in steps]
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
    """Hardness is stiffness step^2 / inertia of the shaft."""
    step, load = 1e-3, ratio * SHAFT
    stiffness = hardness * SHAFT / step**2
    effects = effect_of(new_instance, joint, stiffness, load=load, gap=0.02)
    assert_no_energy_is_created(effects, ratio, step)


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("hardness", [0.1, 10.0, 1e3, 1e5, 1e8])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_a_hard_joint_creates_no_energy(
    new_instance: NewInstance, joint: str, hardness: float, ratio: float
) -> None:
    """As above, however hard, where the effect knows the inertia of the shaft."""
    step, load = 1e-3, ratio * SHAFT
    stiffness = hardness * SHAFT / step**2
    effects = effect_of(new_instance, joint, stiffness, load=load, shaft=SHAFT)
    assert_no_energy_is_created(effects, ratio, step)


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("told", [0.1, 0.5, 1.2])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_a_hard_joint_stays_calm_where_it_is_told_a_wrong_inertia(
    new_instance: NewInstance, joint: str, told: float, ratio: float
) -> None:
    """A user may change the inertia of a corrected twin: shaft and load still come together.

    Told half as much again as the shaft has, a load ten times as heavy diverges.
    """
    step, load = 1e-3, ratio * SHAFT
    stiffness = 1e3 * SHAFT / step**2
    damping = 0.6 * math.sqrt(stiffness * SHAFT * load / (SHAFT + load))
    effects = effect_of(new_instance, joint, stiffness, damping, load, shaft=told * SHAFT)
    run = run_shaft(effects, SHAFT, step, 2000 * step, start=(0.0, 1.0))
    assert np.abs(run.v).max() < 1.001
    load_velocity = SHAFT * (1.0 - run.v[-50:]) / load
    assert np.abs(run.v[-50:] - load_velocity).max() < 0.02  # what is left of 1, within the gap


@pytest.mark.parametrize("stiffness", [600.0, 6e4])
def test_hard_flanks_are_met_within_a_step(new_instance: NewInstance, stiffness: float) -> None:
    """Contacts at 0.2 and 2 kHz under steps of 1 ms, against an independent solver."""
    damping = 2.0 * 0.3 * math.sqrt(stiffness * SHAFT * LOAD / (SHAFT + LOAD))

    exact = two_masses("backlash", stiffness, damping)

    def error(effects: FmuInstance) -> float:
        run = run_shaft(effects, SHAFT, 1e-3, END, drive=pushed(1e-3))
        return float(np.abs(run.q - exact).max() / np.ptp(exact))

    assert error(effect_of(new_instance, "backlash", stiffness, damping, shaft=SHAFT)) < 2e-3
    # Negative control: flanks as soft as a shaft of unknown inertia allows.
    assert error(effect_of(new_instance, "backlash", 100.0, 0.13)) > 4e-3


@pytest.mark.parametrize("step", [1e-3, 5e-4])
def test_a_stiff_shaft_vibrates_as_it_should(new_instance: NewInstance, step: float) -> None:
    """A blow rings at 150 Hz; in closed form, the shaft's share of it."""
    w = 2.0 * np.pi * 150.0
    inertia = SHAFT * LOAD / (SHAFT + LOAD)
    effects = effect_of(new_instance, "torsional_compliance", inertia * w**2, shaft=SHAFT)
    run = run_shaft(effects, SHAFT, step, 0.05, start=(0.0, 1.0))
    together = SHAFT / (SHAFT + LOAD)
    exact = together + (1.0 - together) * np.cos(w * run.t)
    assert np.abs(run.v - exact).max() < 0.02 * step / 1e-3


@pytest.mark.parametrize("joint", JOINTS)
def test_soft_joints_are_the_same_with_and_without_the_inertia_of_the_shaft(
    new_instance: NewInstance, joint: str
) -> None:
    """Limit case: where steps are short for the joint, the two ways agree."""
    step = 2e-5
    known = with_load(new_instance, joint, step, shaft=SHAFT)
    unknown = with_load(new_instance, joint, step)
    assert np.abs(known.q - unknown.q).max() < 1e-3 * np.ptp(unknown.q)


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
