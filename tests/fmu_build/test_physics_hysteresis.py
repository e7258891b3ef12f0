"""Bouc-Wen hysteresis in physics.fmu against the differential equation and its invariants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.fmu_build.shaft import run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

LEVEL, DEFLECTION, SWING, END = 0.3, 0.05, 0.04, 0.3


def torque_on_a_swing(
    new_instance: NewInstance, exponent: float, step: float
) -> NDArray[np.float64]:
    """Torque at the ends of steps; q = swing sin(2 pi 6.25 t) turns between two of them."""
    effects = new_instance("physics").start(
        hysteresis__level=LEVEL, hysteresis__deflection=DEFLECTION, hysteresis__exponent=exponent
    )
    t = np.arange(round(END / step) + 1) * step
    velocity = np.diff(SWING * np.sin(2.0 * np.pi * 6.25 * t)) / step
    return effects.run({"state.velocity": velocity}, ["torque"], step)[1:, 0]


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 6.0])
def test_it_converges_to_the_equation_of_bouc_and_wen(
    new_instance: NewInstance, exponent: float
) -> None:
    """Second order in the step; exact for exponent 1."""

    def slope(t: float, z: NDArray[np.float64]) -> list[float]:
        rate = SWING * 2.0 * np.pi * 6.25 * np.cos(2.0 * np.pi * 6.25 * t)
        grip = np.abs(z[0]) ** exponent * (0.5 * np.sign(z[0] * rate) + 0.5)
        return [rate / DEFLECTION * (1.0 - grip)]

    exact = solve_ivp(slope, (0.0, END), [0.0], rtol=1e-10, atol=1e-12, max_step=1e-4).y[0, -1]
    errors = [
        abs(torque_on_a_swing(new_instance, exponent, step)[-1] + LEVEL * exact)
        for step in (2e-3, 1e-3, 5e-4)
    ]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert max(errors) < 1e-8 if exponent == 1.0 else np.all(orders > 1.7), errors
    assert errors[-1] < 1e-4 * LEVEL


@pytest.mark.parametrize("exponent", [1.0, 2.0, 20.0])
@pytest.mark.parametrize("velocity", [1e-3, 1.0, 1e6])
def test_it_saturates_at_minus_the_level_and_never_beyond(
    new_instance: NewInstance, exponent: float, velocity: float
) -> None:
    effects = new_instance("physics").start(
        hysteresis__level=LEVEL, hysteresis__deflection=1e-4, hysteresis__exponent=exponent
    )
    speeds = velocity * np.repeat([1.0, -1.0, 1.0], 2000)
    torque = effects.run({"state.velocity": speeds}, ["torque"], 1e-3)[1:, 0]
    assert np.abs(torque).max() <= LEVEL
    np.testing.assert_allclose(torque[1999::2000], [-LEVEL, LEVEL, -LEVEL], rtol=1e-8)


def test_with_exponent_1_a_first_loading_is_an_exponential(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(hysteresis__level=LEVEL, hysteresis__deflection=0.02)
    torque = effects.run({"state.velocity": np.full(200, 0.5)}, ["torque"], 1e-3)[1:, 0]
    travel = 0.5e-3 * np.arange(1, 201)
    np.testing.assert_allclose(torque, -LEVEL * (1.0 - np.exp(-travel / 0.02)), rtol=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_a_mass_on_it_only_loses_energy(new_instance: NewInstance, exponent: float) -> None:
    effects = new_instance("physics").start(
        hysteresis__level=0.01, hysteresis__deflection=0.02, hysteresis__exponent=exponent
    )
    run = run_shaft(effects, 1e-3, 1e-3, 1.0, start=(0.0, 0.5))
    peaks = np.abs(run.v[1:]).reshape(4, 250).max(axis=1)
    assert peaks[0] < 0.5
    assert np.all(np.diff(peaks) < -0.02), peaks
