"""Reversals, directions and loads of a trajectory."""

from __future__ import annotations

import numpy as np

from gmfbo.physics import States
from tests.physics.excitations import clock


def turning(rest: float = 0.0) -> States:
    """Forward for one second, standing for half, backward for one."""
    time = clock(2500, 1e-3)
    velocity = np.where(time < 1.0, 1.0, np.where(time < 1.5, 0.0, -1.0))
    position = np.cumsum(velocity) * 1e-3
    command = np.sin(20.0 * time)
    return States(time, position, velocity, command, command, rest)


def test_a_reversal_lasts_from_leaving_one_direction_to_taking_the_other() -> None:
    states = turning()
    near = states.time[states.near_reversals(0.05)]
    assert abs(near[0] - 0.949) < 1e-9
    assert abs(near[-1] - 1.55) < 1e-9


def test_noise_below_rest_is_no_reversal() -> None:
    states = turning(rest=0.01)
    noise = 0.005 * np.where(np.arange(2500) % 2 == 0, 1.0, -1.0)
    noisy = States(
        states.time,
        states.position,
        states.velocity + noise,
        states.command,
        states.current,
        rest=0.01,
    )
    assert np.array_equal(noisy.near_reversals(), states.near_reversals())
    assert np.max(np.abs(noisy.direction[1000:1500])) == 0.5
    assert np.all(noisy.direction[:1000] == 1.0)


def test_a_single_direction_has_no_reversal() -> None:
    time = clock(100, 1e-2)
    ones = np.ones(100)
    assert not States(time, time, ones, ones, ones).near_reversals().any()


def test_the_load_is_the_current_unless_it_is_known() -> None:
    states = turning()
    assert np.array_equal(states.load, np.abs(states.current))
    known = States(
        states.time,
        states.position,
        states.velocity,
        states.command,
        states.current,
        load_torque=-2.0 * np.ones(2500),
    )
    assert np.all(known.load == 2.0)
