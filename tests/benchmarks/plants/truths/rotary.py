"""Two masses on a shaft behind a drive with delay and lag, with friction: three of the plants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from gmfbo.recordings.recording import Recording
from tests.benchmarks.plants.truths.conditions import Conditions, Fallen, Vector
from tests.benchmarks.plants.truths.laws import Cascade, Pid, Rate

SAMPLE = 1e-3
"""[s] Of every controller here, and of every recording."""

SUBSTEPS = 10
"""Semi-implicit Euler steps a sample: 0.1 ms, a fortieth of the shortest period of a shaft here."""


class Law(Protocol):
    """A sampled controller."""

    def next(self, reference: float, measured: float) -> float: ...


@dataclass(frozen=True)
class Rotary:
    """Parameters of the plant, SI.

    Attributes
    ----------
    inertia, viscous : float
        Of the motor [kg m2], [N m s/rad].
    torque_constant : float
        [N m/A]
    coulomb, breakaway, slow : float
        Coulomb friction and what holds beyond it at rest [N m]; speed at which that has fallen to
        1/e [rad/s].
    delay : int
        Samples from the command to the drive.
    lag : float
        [s] Time constant of the torque.
    load_inertia, stiffness, damping : float
        Load behind a shaft [kg m2], [N m/rad], [N m s/rad]; without an inertia there is none.
    quantum : float
        [rad] Of the encoder.
    """

    inertia: float
    viscous: float
    torque_constant: float
    coulomb: float
    breakaway: float = 0.0
    slow: float = 0.5
    delay: int = 1
    lag: float = 5e-4
    load_inertia: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    quantum: float = 2.0 * math.pi / 65536

    def under(self, conditions: Conditions) -> Rotary:
        """The plant with the friction and the inertia of a run."""
        return replace(
            self,
            coulomb=conditions.friction * self.coulomb,
            breakaway=conditions.friction * self.breakaway,
            inertia=conditions.inertia * self.inertia,
            load_inertia=conditions.inertia * self.load_inertia,
        )

    def friction(self, velocity: float) -> float:
        """Torque of the friction [N m]; the sign is smoothed over 10 mrad/s."""
        level = self.coulomb + self.breakaway * math.exp(-((velocity / self.slow) ** 2))
        return level * math.tanh(velocity / 0.01)

    def play(self, law: Law, reference: Vector, noise: Vector, *, speed: Rate | None) -> Vector:
        """Columns reading, held command and velocity of a run from rest, shape (3, rows).

        Parameters
        ----------
        law : Law
            Controller.
        reference : ndarray, shape (rows,)
            Of each sample.
        noise : ndarray, shape (rows,)
            [rad] Of the encoder.
        speed : Rate or None
            Makes the controlled velocity out of the readings; None controls the position.

        Raises
        ------
        Fallen
            The motor turns faster than any real one.
        """
        q = w = load_q = load_w = torque = twist = 0.0
        waiting, command, out = [0.0] * self.delay, 0.0, np.empty((3, len(reference)))
        h = SAMPLE / SUBSTEPS
        share = -math.expm1(-h / self.lag)
        for k, wanted in enumerate(reference.tolist()):
            reading = self.quantum * math.floor((q + noise[k]) / self.quantum + 0.5)
            measured = reading if speed is None else speed.next(reading)
            out[:, k] = reading, command, measured
            command = law.next(wanted, measured)
            waiting.append(command)
            target = self.torque_constant * waiting.pop(0)
            for _ in range(SUBSTEPS):
                torque += share * (target - torque)
                if self.load_inertia:
                    twist = self.stiffness * (q - load_q) + self.damping * (w - load_w)
                    load_w += h / self.load_inertia * twist
                    load_q += h * load_w
                # Friction implicitly: it slows down, and stops, but never turns back.
                free = w + h / self.inertia * (torque - self.viscous * w - twist)
                brake = h / self.inertia * abs(self.friction(free))
                w = math.copysign(max(abs(free) - brake, 0.0), free)
                q += h * w
            if abs(w) > 1e4:
                raise Fallen("the motor races")
        return out


def _short(gains: Mapping[str, float]) -> dict[str, float]:
    """Gains without the name of their controller."""
    return {name.rpartition(".")[2]: value for name, value in gains.items()}


def _of_position(
    plant: Rotary, law: Law, reference: Recording, conditions: Conditions, deviation: float
) -> dict[str, Vector]:
    wanted = reference.signal("reference")
    noise = conditions.noise(deviation, len(wanted))
    rubbed = plant.under(conditions)
    position, current, _ = rubbed.play(law, wanted, noise, speed=None)
    return {"time": reference.time, "reference": wanted, "position": position, "current": current}


TWO_MASSES = Rotary(
    inertia=0.004,
    viscous=0.03,
    torque_constant=0.5,
    coulomb=0.3,
    breakaway=0.1,
    load_inertia=0.006,
    stiffness=380.0,
    damping=0.06,
    delay=1,
)


def two_mass(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """A load of 1.5 times the motor behind a shaft that swings at 40 Hz, and friction."""
    law = Cascade(
        {**_short(gains), "ki": 20.0},
        sample=SAMPLE,
        filter_time=1e-3,
        limits=(-30.0, 30.0),
        anti_windup=100.0,
    )
    return _of_position(TWO_MASSES, law, reference, conditions, 5e-5)


SIX = Rotary(
    inertia=0.0055,
    viscous=0.06,
    torque_constant=0.5,
    coulomb=0.35,
    breakaway=0.15,
    load_inertia=0.005,
    stiffness=2500.0,
    damping=0.3,
    delay=2,
)


def six_gains(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """Friction, a delay of two samples and a shaft that swings at 110 Hz."""
    named = _short(gains)
    filter_time = named.pop("filter_time")
    law = Cascade(named, sample=SAMPLE, filter_time=filter_time, limits=(-30.0, 30.0))
    return _of_position(SIX, law, reference, conditions, 3e-4)


SPINDLE = Rotary(
    inertia=0.0048,
    viscous=0.012,
    torque_constant=0.5,
    coulomb=0.5,
    delay=3,
    lag=1.5e-3,
    quantum=2.0 * math.pi / 16384,
)


def velocity_loop(
    gains: Mapping[str, float], reference: Recording, conditions: Conditions
) -> dict[str, Vector]:
    """A spindle whose speed comes from a coarse encoder by way of a filter of 2 ms."""
    wanted = reference.signal("reference")
    law = Pid(_short(gains), sample=SAMPLE, limits=(-20.0, 20.0), anti_windup=50.0)
    rubbed = SPINDLE.under(conditions)
    noise = conditions.noise(3e-4, len(wanted))
    _, current, speed = rubbed.play(law, wanted, noise, speed=Rate(2e-3, SAMPLE))
    return {"time": reference.time, "reference": wanted, "velocity": speed, "current": current}
