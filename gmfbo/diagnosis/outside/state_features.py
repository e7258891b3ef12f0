"""Torques without a law: piecewise linear over a state, each knot's value free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from gmfbo.diagnosis.screening.port_response import between_points
from gmfbo.physics import States

Array = NDArray[np.float64]

_SPEED_SHARES = (0.004, 0.02, 0.08, 0.2, 0.4, 0.68, 1.0)  # of the range: laws bend near standstill
_POSITION_KNOTS = 11


@dataclass(frozen=True, eq=False)
class Family:
    """Torques that depend on one state in any way.

    Attributes
    ----------
    against : str
        The state, in words.
    unit : {"velocity", "position"}
        Quantity that the knots are in.
    knots : ndarray, shape (n_knots,)
        Rising values of the state.
    turn : ndarray, shape (n_values, n)
        Values at the knots by each free number.
    columns : tuple of ndarray, shape (n, rows)
        Of each recording: torque along it by each free number alone.
    """

    against: str
    unit: str
    knots: Array
    turn: Array
    columns: tuple[Array, ...]


def hats(values: Array, knots: Array) -> Array:
    """Triangles that are one at their knot and zero at the next, shape (n_knots, n_values).

    Beyond the outermost knots their triangles stay one: a torque does not end there.

    Parameters
    ----------
    values : ndarray, shape (n_values,)
        Of the state.
    knots : ndarray, shape (n_knots,)
        Rising.
    """
    return np.array([np.interp(values, knots, row) for row in np.eye(knots.size)])


def hinges(knots: Array) -> Array:
    """Values at the knots by a level, a slope, and a bend at each inner knot, shape (n, n).

    Without bends a line goes on beyond what was seen, which hats would not know of.

    Parameters
    ----------
    knots : ndarray, shape (n,)
        Rising.
    """
    if knots.size == 1:
        return np.ones((1, 1))
    extent = knots[-1] - knots[0]
    bends = np.maximum(knots[:, None] - knots[None, 1:-1], 0.0) / extent
    return np.column_stack([np.ones(knots.size), (knots - knots[0]) / extent, bends])


def of_velocity(states: Sequence[States]) -> Family | None:
    """Free function of the velocity, each direction for itself; None where nothing moves."""
    velocity = np.concatenate([s.velocity for s in states])
    forth, back = float(np.quantile(velocity, 0.998)), -float(np.quantile(velocity, 0.002))
    fastest = max(forth, back)
    if fastest <= 0.0:
        return None
    shares = np.array(_SPEED_SHARES)
    slowest = 2.0 * shares[0] * fastest
    above = shares * forth if forth > slowest else np.zeros(0)
    below = -shares[::-1] * back if back > slowest else np.zeros(0)
    knots = np.concatenate([below, [0.0], above])
    # Each direction is a curve of its own: what opposes the motion jumps at standstill.
    turn = block_diag(*(hinges(side) for side in (below, np.zeros(1), above) if side.size))
    columns = tuple(between_points(turn.T @ hats(s.velocity, knots)) for s in states)
    return Family("velocity", "velocity", knots, turn, columns)


def of_position(states: Sequence[States]) -> Family | None:
    """Free function of the position; None where nothing moves."""
    position = np.concatenate([s.position for s in states])
    low, high = float(position.min()), float(position.max())
    if high <= low:
        return None
    knots = np.linspace(low, high, _POSITION_KNOTS)
    turn = hinges(knots)
    columns = tuple(between_points(turn.T @ hats(s.position, knots)) for s in states)
    return Family("position", "position", knots, turn, columns)


def of_folded_position(states: Sequence[States], period: float) -> Family:
    """Free function of the position within one period of what repeats over it.

    Parameters
    ----------
    states : sequence of States
        Of each recording.
    period : float
        [unit of the position] Positive.
    """
    knots = np.linspace(0.0, period, _POSITION_KNOTS)
    # The end of a period is its start: one value for both.
    turn = np.vstack([np.eye(knots.size - 1), np.eye(1, knots.size - 1)])
    columns = tuple(
        between_points(turn.T @ hats(np.mod(s.position, period), knots)) for s in states
    )
    return Family("position within one period", "position", knots, turn, columns)
