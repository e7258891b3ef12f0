"""A mass under the torque of physics.fmu: the simplest twin, exact for a torque that is held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.fmu_build.fmu_instance import FmuInstance

Drive = Callable[[float, float, float], float]


@dataclass(frozen=True)
class ShaftRun:
    """Motion of the shaft.

    Attributes
    ----------
    t : array, shape (steps + 1,)
        [s]
    q, v : array, shape (steps + 1,)
        Position and velocity at `t`.
    torque : array, shape (steps,)
        Torque of the effects, held over each step.
    """

    t: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    torque: NDArray[np.float64]


def no_drive(t: float, q: float, v: float) -> float:
    """No torque but that of the effects."""
    return 0.0


def run_shaft(
    effects: FmuInstance,
    inertia: float,
    step: float,
    duration: float,
    start: tuple[float, float] = (0.0, 0.0),
    drive: Drive = no_drive,
) -> ShaftRun:
    """Integrate inertia * acceleration = drive(t, q, v) + effects, both held over each step.

    Parameters
    ----------
    effects : FmuInstance
        physics.fmu, initialised.
    inertia : float
        Of the shaft.
    step, duration : float
        [s]
    start : tuple of float
        Position and velocity.
    drive : callable
        Torque at (t, q, v), taken at the start of each step.
    """
    names = ("state.position", "state.velocity")
    inputs = [effects.variables[name].valueReference for name in names]
    output = [effects.variables["torque"].valueReference]
    steps = round(duration / step)
    q, v, torque = np.empty(steps + 1), np.empty(steps + 1), np.empty(steps)
    q[0], v[0] = start
    for k in range(steps):
        now = k * step
        effects.slave.setReal(inputs, [float(q[k]), float(v[k])])
        effects.step(now, step)
        torque[k] = effects.slave.getReal(output)[0]
        acceleration = (drive(now, float(q[k]), float(v[k])) + torque[k]) / inertia
        q[k + 1] = q[k] + (v[k] + 0.5 * acceleration * step) * step
        v[k + 1] = v[k] + acceleration * step
    return ShaftRun(np.arange(steps + 1, dtype=np.float64) * step, q, v, torque)
