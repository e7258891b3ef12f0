"""A change of direction counts where the axis travels on after it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.measured_excitation import reversals
from gmfbo.physics import States

Array = NDArray[np.float64]
TIME = np.linspace(0.0, 2.0, 4001)


def moved(position: Array) -> States:
    """States of an axis that moves so."""
    still = np.zeros_like(TIME)
    return States(TIME, position, np.gradient(position, TIME), still, still)


@given(st.integers(1, 20), st.floats(1e-6, 1e6))
def test_a_cosine_turns_twice_a_period(periods: int, stroke: float) -> None:
    """Whatever the unit; at its end it is where it turns."""
    position = stroke * np.cos(np.pi * periods * TIME)
    assert reversals(moved(position)) == 2 * periods - 1


@pytest.mark.parametrize(("back", "turns"), [(5e-4, 0), (0.02, 2)])
def test_going_back_counts_by_its_share_of_the_stroke(back: float, turns: int) -> None:
    bump = np.where((TIME > 1.0) & (TIME < 1.2), np.sin(5.0 * np.pi * (TIME - 1.0)) ** 2, 0.0)
    position = np.clip(TIME, None, 1.0) + np.clip(TIME - 1.2, 0.0, None) - 2.0 * back * bump
    assert reversals(moved(position)) == turns


@given(st.integers(0, 2**32 - 1))
def test_jitter_while_it_moves_one_way_turns_nothing(seed: int) -> None:
    """As of encoder counts that a stiff loop follows: many velocities are negative."""
    jitter = 9e-4 * np.random.default_rng(seed).uniform(-1.0, 1.0, TIME.size)
    states = moved(TIME + jitter)
    assert np.mean(states.velocity < 0.0) > 0.05
    assert reversals(states) == 0


def test_two_recordings_the_other_way_each_are_one_reversal_together() -> None:
    there, back = moved(TIME), moved(-TIME)
    assert reversals(there) == reversals(back) == 0
    assert reversals(there, back) == 1
    assert reversals(there, there) == 0


def test_an_axis_at_rest_does_not_turn() -> None:
    assert reversals(moved(np.zeros_like(TIME))) == 0
