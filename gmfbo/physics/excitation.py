"""Excitation: ranges of the axis' motion in a set of recordings, in the twin's units."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gmfbo.errors import InputError

_POSITIVE = (
    "torque",
    "command",
    "command_rate",
    "current",
    "speed",
    "stroke",
    "resolution",
    "duration",
    "total",
    "sample",
    "step",
    "loop_time",
)


NOTHING = 1e-9
"""What stands for a range that is zero: laws are scaled by it."""


@dataclass(frozen=True)
class Excitation:
    """Ranges that bound and scale the parameters of effects; all sizes are positive.

    Attributes
    ----------
    torque : float
        Torque (or force) at the port that corresponds to the range of the command.
    command : float
        Largest `|command|`.
    command_rate : float
        Largest `|d command / dt|` from row to row [command/s].
    current : float
        Largest `|current|`, or `|command|` where no current is known.
    speed : float
        99.5 % quantile of `|velocity|`.
    stroke : float
        Range of the position over all recordings.
    resolution : float
        Smallest significant position step: encoder quantum or noise.
    duration, total : float
        [s] Longest recording, and all together.
    sample : float
        Sampling time of the recordings [s].
    step : float
        Communication step at which effects are stepped [s].
    loop_time : float
        Slowest relevant time constant of the closed loop [s].
    inertia : float or None
        Torque per acceleration of the twin's shaft, if the twin names it or it was measured.
    angular : bool
        Whether the position is an angle [rad]; else it is a length [m].
    reversals : int
        Changes of direction after which the axis travels on by a thousandth of its stroke.
    load : float or None
        Largest `|load torque|` where that state is known; else the current replaces it.
    effective_current : float or None
        Root mean square of the current; None where it was not measured.
    wavenumbers : tuple of float
        Strong lines in the spectrum over position [rad per position unit], strongest first.
    ripple_wavenumbers : tuple of float
        Lines over position that grow with the current [rad per position unit], strongest first.
    frequencies : tuple of float
        Strong lines over time [Hz], strongest first.
    pulses : tuple of tuple of float
        Candidates for a passing disturbance: (start, duration) [s].
    demands : tuple of tuple of float
        Velocity along the command and its size at one instant: those beyond which none lies.

    Raises
    ------
    InputError
        A range is not positive and finite, so it cannot serve as a scale.
    """

    torque: float
    command: float
    command_rate: float
    current: float
    speed: float
    stroke: float
    resolution: float
    duration: float
    total: float
    sample: float
    step: float
    loop_time: float
    inertia: float | None
    angular: bool
    reversals: int
    load: float | None = None
    effective_current: float | None = None
    wavenumbers: tuple[float, ...] = ()
    ripple_wavenumbers: tuple[float, ...] = ()
    frequencies: tuple[float, ...] = ()
    pulses: tuple[tuple[float, float], ...] = ()
    demands: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        for name in _POSITIVE:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(
                    f"expected recordings that show a {name.replace('_', ' ')} above zero, "
                    f"got {value!r}; record the axis while it moves"
                )
        if self.inertia is not None and not (math.isfinite(self.inertia) and self.inertia > 0.0):
            raise InputError(
                f"expected an inertia above zero, got {self.inertia!r}; "
                "correct the twin's [roles] or leave the inertia out"
            )

    @property
    def shaft_inertia(self) -> float:
        """Inertia of the shaft; if unknown, the one that `torque` brings to `speed` in `loop_time`.

        An order of magnitude is enough to keep elastic elements numerically stable.
        """
        if self.inertia is not None:
            return self.inertia
        return self.torque * self.loop_time / self.speed

    def largest_demand(self, slope: float) -> float:
        """Largest `|command + slope * velocity|` of the motion; that of the ranges if unknown.

        A limit that falls by `slope` acts if it is less at standstill.

        Parameters
        ----------
        slope : float
            [command/velocity] At least 0.
        """
        met = self.demands or ((self.speed, self.command),)
        return max(abs(command + slope * speed) for speed, command in met)

    @property
    def is_loaded(self) -> bool:
        """Whether there is any load, or current in its place."""
        return self.load_range > NOTHING

    @property
    def load_range(self) -> float:
        """Largest `|load torque|`, or largest `|current|` in its place."""
        return self.current if self.load is None else self.load
