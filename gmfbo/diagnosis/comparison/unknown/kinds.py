"""Free functions of the states at each port, as signals of unit size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import ends_of, motion_of, smooth
from gmfbo.diagnosis.comparison.numbers import SMOOTH_BUMPS
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.problem import Problem

Array = NDArray[np.float64]

_FINE, _FINE_COMMAND, _COARSE = 40, 64, 8  # bumps over a state
_STEPS, _STEEP = 256, 1.0  # bumps of what counts or ripples, and over which they are smooth
_TICK_S, _MOST_TICKS = 0.01, 400  # of what repeats from recording to recording
_PLAIN = 16.0  # bumps of the fine ones over which a spring or a drag is smooth


@dataclass(frozen=True, eq=False)
class Kind:
    """Free functions of one kind.

    Attributes
    ----------
    port : str
        Where they act: `torque`, `command` or `sensor`.
    against : str
        On what they depend: `position`, `velocity`, `command` or `time` since the start.
    signals : list of ndarray, shape (c, rows)
        [FMU's unit of the port] By recording: c functions of unit size along it.
    ways : tuple of (str, list of ndarray, shape (rows,))
        In which a value over the state may act: what is said of it, and its factor by recording.
    unit : float
        [FMU's unit of the port / FMU's unit of the torque port] A unit size.
    """

    port: str
    against: str
    signals: list[Array]
    ways: tuple[tuple[str, list[Array]], ...]
    unit: float = 1.0

    @property
    def count(self) -> int:
        """Number of functions."""
        return len(self.signals[0])


def kinds(problem: Problem, kernels: PortKernels, row: Fitted) -> list[Kind]:
    """Kinds that a twin's ports allow, along the motion of a fit.

    Parameters
    ----------
    problem : Problem
        Recordings.
    kernels : PortKernels
        For the ports.
    row : Fitted
        Whose simulated states are taken: of a fit near the recordings.
    """
    ports, motion = kernels.simulated.keys(), motion_of(problem, row)
    over_position = _over(motion.positions, _FINE)
    made = []
    plain = (("", [np.ones(v.size) for v in motion.positions]),)
    if "torque" in ports:
        moving = motion.velocities
        over_speed, turning = _over(motion.speeds, _FINE), _rates(motion.speeds)
        shares = [v / motion.fast for v in moving]
        dragged = [own * share for own, share in zip(over_position, shares, strict=True)]
        both = _products(_over(motion.positions, _COARSE), _over(motion.speeds, _COARSE))
        of_speed = (*plain, (", with the sign of the acceleration", _signs(turning)))
        of_place = (*plain, (", with the sign of the velocity", _signs(moving)))
        in_proportion = ((", in proportion to the velocity (at its largest)", shares),)
        passed, longest = _passed(problem)
        growing = [own * share for own, share in zip(over_speed, passed, strict=True)]
        in_time = ((", in proportion to the time since the start (at the end)", passed),)
        made += [
            Kind("torque", "velocity", over_speed, plain),
            Kind("torque", "velocity", _over(motion.velocities, _FINE, _PLAIN), plain),
            Kind("torque", "position", _over(motion.positions, _FINE, _PLAIN), plain),
            Kind("torque", "velocity", _each_way(over_speed, turning), of_speed),
            Kind("torque", "position", over_position, plain),
            Kind("torque", "position", _each_way(over_position, moving), of_place),
            Kind("torque", "position", dragged, in_proportion),
            Kind("torque", "velocity", both, plain),
            Kind("torque", "velocity", growing, in_time),
        ]
        if len(passed) > 1:  # of one recording it is noise
            made.append(Kind("torque", "time", _ticks(passed, longest), plain))
    states = [run.response.states for run in row.runs]
    if "command" in ports and all("command" in own for own in states):
        command = [own["command"] for own in states]
        over_command, rising = _over(command, _FINE_COMMAND), _rates(command)
        each_way = _each_way(over_command, rising)
        of_command = (*plain, (", with the sign of its rate", _signs(rising)))
        made += [
            Kind("command", "command", over_command, plain),
            Kind("command", "command", _over(command, _STEPS, _STEEP), plain),
            Kind("command", "command", each_way, of_command),
        ]
    if "sensor" in ports and kernels.controller is None:
        made.append(Kind("sensor", "position", over_position, plain))
        rippled = _over(motion.positions, _STEPS, _STEEP)
        made.append(Kind("sensor", "position", rippled, plain))
    return made


def _passed(problem: Problem) -> tuple[list[Array], float]:
    """Time since the start of each recording, as a share of the longest one's, and that [s]."""
    grids = [record.plan.grid for record in problem.simulations.records]
    longest = max(float(grid[-1] - grid[0]) for grid in grids)
    return [(grid - grid[0]) / longest for grid in grids], longest


def _ticks(passed: Sequence[Array], longest: float) -> list[Array]:
    """Functions of the time since the start that are the same in all recordings, shape (c, n).

    Zero where only one recording is that long: what it holds there is noise.
    """
    shared = sorted(float(own[-1]) for own in passed)[-2]
    count = int(np.clip(np.ceil(shared * longest / _TICK_S), 2, _MOST_TICKS))
    return [_with_level(smooth(own, 0.0, shared, count)) * (own <= shared) for own in passed]


def _over(columns: Sequence[Array], count: int, over: float = SMOOTH_BUMPS) -> list[Array]:
    """Smooth functions over the range that a state has in all recordings, shape (c, n)."""
    low, high = ends_of(columns)
    return [_with_level(smooth(values, low, high, count, over)) for values in columns]


def _with_level(functions: Array) -> Array:
    """The same functions and a level of their size, shape (c + 1, n).

    They could make one themselves, but each would have to be as large as it: a constant torque
    beside smaller ones would be likelier, whatever acts.
    """
    return np.concatenate([functions, np.ones((1, functions.shape[1]))])


def _signs(columns: Sequence[Array]) -> list[Array]:
    return [np.where(values > 0.0, 1.0, -1.0) for values in columns]


def _rates(columns: Sequence[Array]) -> list[Array]:
    return [np.gradient(values) for values in columns]


def _each_way(functions: Sequence[Array], rates: Sequence[Array]) -> list[Array]:
    """Functions of their own for each direction, shape (2 c, n)."""
    return [
        np.concatenate([own * (rate > 0.0), own * (rate <= 0.0)])
        for own, rate in zip(functions, rates, strict=True)
    ]


def _products(first: Sequence[Array], second: Sequence[Array]) -> list[Array]:
    """Products of functions of two states, shape (c d, n)."""
    return [(a[:, None] * b).reshape(-1, a.shape[1]) for a, b in zip(first, second, strict=True)]
