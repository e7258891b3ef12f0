"""Maxwell-slip hysteresis in physics.fmu against its invariants."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.physics import CATALOGUE
from gmfbo.physics.states import States
from tests.fmu_build.shaft import run_shaft

if TYPE_CHECKING:
    from tests.fmu_build.conftest import NewInstance

LEVEL, DEFLECTION, STEP = 0.3, 0.05, 1e-3


def torque_along(
    new_instance: NewInstance, path: NDArray[np.float64], deflection: float = DEFLECTION
) -> NDArray[np.float64]:
    """Torque at the samples of a path of the position, shape (n,), from rest in the middle."""
    effects = new_instance("physics").start(
        hysteresis__level=LEVEL, hysteresis__deflection=deflection
    )
    velocity = np.concatenate([[0.0], np.diff(path)]) / STEP
    return effects.run({"state.velocity": velocity}, ["torque"], STEP)[1:, 0]


def loading(travel: NDArray[np.float64]) -> NDArray[np.float64]:
    """A first loading of very many elements."""
    return LEVEL * (1.0 - np.exp(-travel / DEFLECTION))


def test_a_first_loading_is_an_exponential_but_for_the_number_of_elements(
    new_instance: NewInstance,
) -> None:
    travel = np.linspace(0.0, 0.5, 501)
    torque = torque_along(new_instance, travel)
    np.testing.assert_allclose(-torque, loading(travel), atol=0.012 * LEVEL)


def test_the_way_back_is_the_first_loading_at_twice_its_size(new_instance: NewInstance) -> None:
    """Masing's rule, exactly, whatever the elements."""
    there = np.linspace(0.0, 0.1, 201)
    back = there[-1] - np.linspace(0.0, 0.2, 401)
    torque = -torque_along(new_instance, np.concatenate([there, back]))
    first, way_back = torque[:201], torque[201:]
    np.testing.assert_allclose(way_back[::2], first[-1] - 2.0 * first, atol=1e-12)


def test_a_small_loop_within_a_large_one_closes(new_instance: NewInstance) -> None:
    path = np.concatenate(
        [np.linspace(0.0, 0.08, 81), np.linspace(0.08, 0.05, 31), np.linspace(0.05, 0.2, 151)]
    )
    straight = np.linspace(0.0, 0.2, 201)
    torque, without = torque_along(new_instance, path), torque_along(new_instance, straight)
    # Behind the corner at 0.08 nothing tells that the loop was there.
    np.testing.assert_allclose(torque[-120:], without[-120:], atol=1e-12)


@pytest.mark.parametrize("velocity", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("deflection", [0.0, 1e-4])
def test_it_saturates_at_minus_the_level_and_never_beyond(
    new_instance: NewInstance, velocity: float, deflection: float
) -> None:
    effects = new_instance("physics").start(
        hysteresis__level=LEVEL, hysteresis__deflection=deflection
    )
    speeds = velocity * np.repeat([1.0, -1.0, 1.0], 2000)
    torque = effects.run({"state.velocity": speeds}, ["torque"], 1e-3)[1:, 0]
    assert np.abs(torque).max() <= LEVEL * (1.0 + 1e-12)
    np.testing.assert_allclose(torque[1999::2000], [-LEVEL, LEVEL, -LEVEL], rtol=1e-12)


def test_the_c_code_follows_the_law_of_the_catalogue(new_instance: NewInstance) -> None:
    path = np.cumsum(0.02 * np.random.default_rng(0).standard_normal(400))
    path -= path[0]
    time, still = np.linspace(0.0, STEP * 399, 400), np.zeros(400)
    states = States(time, path, still, still, still)
    signal = CATALOGUE["hysteresis"].signal
    assert signal is not None
    law = signal(states, {"level": LEVEL, "deflection": DEFLECTION})
    np.testing.assert_allclose(torque_along(new_instance, path), law, atol=1e-8 * LEVEL)


def test_a_step_may_hold_any_travel(new_instance: NewInstance) -> None:
    """The elements follow the position, so that the length of a step has no error."""
    turns = np.array([0.0, 0.07, -0.02, 0.03])
    fine = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(turns)])
    coarse, exact = torque_along(new_instance, turns), torque_along(new_instance, fine)
    np.testing.assert_allclose(coarse[1:], exact[49::50], atol=1e-12)


def test_a_mass_on_it_only_loses_energy(new_instance: NewInstance) -> None:
    effects = new_instance("physics").start(hysteresis__level=0.01, hysteresis__deflection=0.02)
    run = run_shaft(effects, 1e-3, 1e-3, 1.0, start=(0.0, 0.5))
    peaks = np.abs(run.v[1:]).reshape(4, 250).max(axis=1)
    assert peaks[0] < 0.5
    assert np.all(np.diff(peaks) < -0.02), peaks
