"""States: the signals of a trajectory on which effects depend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class States:
    """Signals of one trajectory, each of shape (n,), on one uniform clock.

    Attributes
    ----------
    time : ndarray (n,)
        [s]
    position, velocity, command, current : ndarray (n,)
        In the twin's units; the command replaces an unknown current.
    rest : float
        Speeds below this count as standstill, so that noise has no direction.
    load_torque : ndarray (n,) or None
        Where it is known; else `|current|` replaces it.
    """

    time: Array
    position: Array
    velocity: Array
    command: Array
    current: Array
    rest: float = 0.0
    load_torque: Array | None = None

    @property
    def step(self) -> float:
        """Sampling time [s]."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def acceleration(self) -> Array:
        """Acceleration, shape (n,), by central differences of the velocity."""
        return np.asarray(np.gradient(self.velocity, self.time), dtype=np.float64)

    @property
    def direction(self) -> Array:
        """Sign of the velocity, shape (n,), going to zero linearly within `rest`."""
        if self.rest <= 0.0:
            return np.sign(self.velocity)
        return np.clip(self.velocity / self.rest, -1.0, 1.0)

    @property
    def load(self) -> Array:
        """Amount of load, shape (n,): `|load torque|`, or `|current|` where it is not known."""
        return np.abs(self.current if self.load_torque is None else self.load_torque)

    def near_reversals(self, within: float = 0.05) -> Mask:
        """Mark the samples near a lasting change of direction.

        Parameters
        ----------
        within : float
            Time before and after the change [s].

        Returns
        -------
        ndarray (n,) of bool
            True near a change.
        """
        moving = np.flatnonzero(np.abs(self.velocity) > self.rest)
        signs = np.sign(self.velocity[moving])
        turns = np.flatnonzero(signs[1:] != signs[:-1])
        near = np.zeros(len(self.time), dtype=np.bool_)
        for turn in turns:
            # From the end of one direction to the start of the other, standstill included.
            first, last = self.time[moving[turn]], self.time[moving[turn + 1]]
            near |= (self.time >= first - within) & (self.time <= last + within)
        return near

    def everywhere(self) -> Mask:
        """Mark all samples, shape (n,)."""
        return np.ones(len(self.time), dtype=np.bool_)
