"""Torques without a law: piecewise linear over a state, each knot's value free."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from gmfbo.diagnosis.screening.port_response import between_points
from gmfbo.physics import States

Array = NDArray[np.float64]

_SPEED_SHARES = (0.004, 0.02, 0.08, 0.2, 0.4, 0.68, 1.0)  # of the range: laws bend near standstill
_POSITION_KNOTS = 11
_TIME_KNOTS = 12


@dataclass(frozen=True, eq=False)
class Family:
    """Torques that depend on one state in any way.

    Attributes
    ----------
    name : str
        `velocity`, `position`, `folded_position`, `signed_position`, `damped_position` or `time`.
    against : str
        The state, in words.
    unit : {"velocity", "position", "time"}
        Quantity that the knots are in.
    knots : ndarray, shape (n_knots,)
        Rising values of the state.
    turn : ndarray, shape (n_values, n)
        Values at the knots by each free number.
    bends : ndarray of bool, shape (n,)
        Free numbers that a prior holds back; not so a level and a slope.
    columns : tuple of ndarray, shape (n, rows)
        Of each recording: torque along it by each free number alone.
    shared : bool
        All recordings have the same values; else one set of knots after the other.
    """

    name: str
    against: str
    unit: str
    knots: Array
    turn: Array
    bends: NDArray[np.bool_]
    columns: tuple[Array, ...]
    shared: bool = True


def families(states: Sequence[States]) -> list[Family]:
    """All families over what recordings show."""
    found = [
        of_velocity(states),
        of_position(states),
        _of_signed_position(states),
        _of_position_with_speed(states),
    ]
    return [*(family for family in found if family is not None), _of_time(states)]


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
    bends = np.concatenate([_inner(side) for side in (below, np.zeros(1), above)])
    columns = tuple(between_points(turn.T @ hats(s.velocity, knots)) for s in states)
    return Family("velocity", "velocity", "velocity", knots, turn, bends, columns)


def of_position(states: Sequence[States]) -> Family | None:
    """Free function of the position; None where nothing moves."""
    return _along_position(states, "position", "position", lambda s: [1.0])


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
    free = np.ones(knots.size - 1, dtype=bool)
    against = "position within one period"
    return Family("folded_position", against, "position", knots, turn, free, columns)


def _of_signed_position(states: Sequence[States]) -> Family | None:
    against = "position, with the sign of the velocity"
    return _along_position(states, "signed_position", against, lambda s: [s.direction])


def _of_position_with_speed(states: Sequence[States]) -> Family | None:
    fastest = max(float(np.abs(s.velocity).max()) for s in states)
    if fastest <= 0.0:
        return None
    against = "position, in proportion to the velocity (at its largest)"
    return _along_position(states, "damped_position", against, lambda s: [s.velocity / fastest])


def _along_position(
    states: Sequence[States],
    name: str,
    against: str,
    factors: Callable[[States], Sequence[Array | float]],
) -> Family | None:
    """Curves over the position, each of them times a factor; None where nothing moves."""
    knots = _position_knots(states)
    if knots is None:
        return None
    turn = hinges(knots)
    columns = []
    for s in states:
        along = turn.T @ hats(s.position, knots)
        columns.append(between_points(np.concatenate([f * along for f in factors(s)])))
    curves = len(factors(states[0]))
    bends = np.tile(_inner(knots), curves)
    together = block_diag(*[turn] * curves)
    return Family(name, against, "position", knots, together, bends, tuple(columns))


def _inner(knots: Array) -> NDArray[np.bool_]:
    return np.arange(knots.size) >= 2


def _position_knots(states: Sequence[States]) -> Array | None:
    position = np.concatenate([s.position for s in states])
    low, high = float(position.min()), float(position.max())
    return np.linspace(low, high, _POSITION_KNOTS) if high > low else None


def _of_time(states: Sequence[States]) -> Family:
    """Values of its own for each recording, over the longest one's time."""
    start = min(float(s.time[0]) for s in states)
    end = max(float(s.time[-1]) for s in states)
    knots = np.linspace(start, end, _TIME_KNOTS)
    columns = []
    for k, s in enumerate(states):
        column = np.zeros((len(states) * knots.size, s.time.size))
        column[k * knots.size : (k + 1) * knots.size] = between_points(hats(s.time, knots))
        columns.append(column)
    n = len(states) * knots.size
    free = np.ones(n, dtype=bool)
    return Family("time", "time", "time", knots, np.eye(n), free, tuple(columns), shared=False)
