"""Damper on a test machine: its force and its position, in closed form."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fmu_build.fmu_instance import FmuInstance

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

VISCOUS, STEP = 500.0, 1e-3


def test_the_force_opposes_the_velocity_and_the_port_adds(new_instance: NewInstance) -> None:
    k = np.arange(200)
    velocity, port = 0.1 * np.sin(0.1 * k), 3.0 * np.cos(0.03 * k)
    damper = new_instance("damper").start()
    table = damper.run({"velocity": velocity, "port__force": port}, ["force", "rod_velocity"], STEP)
    np.testing.assert_allclose(table[1:, 0], port - VISCOUS * velocity, rtol=1e-14, atol=1e-13)
    np.testing.assert_array_equal(table[1:, 1], velocity)


def test_the_position_is_the_integral_of_the_held_velocity(new_instance: NewInstance) -> None:
    velocity = 0.1 * np.sin(0.1 * np.arange(200))
    damper = new_instance("damper").start(initial_position=0.02)
    position = damper.run({"velocity": velocity}, ["position"], STEP)[:, 0]
    assert position[0] == 0.02
    np.testing.assert_allclose(position[1:], 0.02 + STEP * np.cumsum(velocity), atol=1e-15)


def test_a_cycle_takes_the_energy_of_the_closed_form(new_instance: NewInstance) -> None:
    """A sinusoidal stroke X at w takes pi c w X^2 a cycle, wherever the force port is quiet."""
    stroke, rate = 0.01, 2.0 * np.pi
    velocity = stroke * rate * np.cos(rate * (np.arange(1000) + 0.5) * STEP)
    table = new_instance("damper").start().run({"velocity": velocity}, ["force", "position"], STEP)
    taken = -float(np.sum(table[1:, 0] * np.diff(table[:, 1])))
    assert taken == pytest.approx(np.pi * VISCOUS * rate * stroke**2, rel=1e-10)


def test_the_communication_step_changes_nothing(new_instance: NewInstance) -> None:
    velocity = 0.1 * np.sin(0.3 * np.arange(50))
    names = ["force", "position"]
    coarse = new_instance("damper").start().run({"velocity": velocity}, names, 10 * STEP)
    fine = new_instance("damper").start().run({"velocity": np.repeat(velocity, 10)}, names, STEP)
    np.testing.assert_allclose(fine[::10], coarse, rtol=0.0, atol=1e-13)


@given(st.floats(-1e3, 1e3), st.floats(-1e5, 1e5), st.floats(0.0, 1e5))
def test_the_force_is_linear_from_the_first_instant_on(
    unpacked: Callable[[str], Path], velocity: float, port: float, viscous: float
) -> None:
    damper = FmuInstance(unpacked("damper"))
    damper.start(velocity=velocity, port__force=port, viscous=viscous)
    force = damper.get("force")
    damper.close()
    assert force == pytest.approx(port - viscous * velocity, rel=1e-12, abs=1e-9)


def test_divergence_of_the_damper_is_reported_in_words(new_instance: NewInstance) -> None:
    damper = new_instance("damper").start(velocity=1e308)
    with pytest.raises(RuntimeError, match="the damper has diverged"):
        damper.run({}, ["force"], 10.0, rows=3)
