"""A plant of low order under a control law, many loops at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.methods.low_order.control_law import ControlLaw, features_of

Vector = NDArray[np.float64]

MOST = 1e6
"""Measurements are cut to this many sizes of the reference: an unstable loop ends as a number."""


@dataclass(frozen=True, eq=False)
class PlantModel:
    """y'' = b u(t - delay) - a y' - k (y - y_0) - c sign(y') + o, for L plants.

    An inertia with friction has k = 0; a body with a heat capacity and a slow sensor has both, and
    a speed with a lag as well.

    Attributes
    ----------
    gain, damping, stiffness, coulomb, offset : ndarray, shape (L,)
        b [unit/s2 of y per unit of u], a [1/s], k [1/s2], c and o [unit/s2 of y].
    delay : ndarray, shape (L,)
        [s] Beside the hold of the controller; zero or more.
    """

    gain: Vector
    damping: Vector
    stiffness: Vector
    coulomb: Vector
    offset: Vector
    delay: Vector

    def repeated(self, times: int) -> PlantModel:
        """Each plant so many times, one after the other."""
        each = (self.gain, self.damping, self.stiffness, self.coulomb, self.offset, self.delay)
        return PlantModel(*(np.repeat(values, times) for values in each))


def simulate(
    law: ControlLaw,
    plants: PlantModel,
    gains: Vector,
    reference: Vector,
    start: Vector,
    step: float,
) -> tuple[Vector, Vector]:
    """Measurement and command of L loops from rest, shape (L, n) each.

    The velocity follows each sample exactly under held forces, Coulomb friction brakes without
    turning back, and a delay between two samples takes the line between their commands.

    Parameters
    ----------
    law : ControlLaw
        Of all loops.
    plants : PlantModel
        L of them.
    gains : ndarray, shape (L, d)
        As the law takes them.
    reference : ndarray, shape (L, n)
        [unit of the measurement]
    start : ndarray, shape (2, L)
        First measurement and command.
    step : float
        [s] Between two samples.
    """
    loops, count = reference.shape
    coefficients = law.coefficients(gains)
    seen = features_of(reference, np.zeros_like(reference), law.delay)
    y, u = np.empty((loops, count)), np.empty((loops, count))
    y[:, 0], u[:, 0] = start
    wanted = np.stack([start[1], start[1]])
    whole, part = _late(plants, step)
    decay = np.exp(-plants.damping * step)
    reach = np.where(plants.damping > 0.0, (1.0 - decay) / np.maximum(plants.damping, 1e-300), step)
    most = MOST * max(float(np.ptp(reference)), np.finfo(float).tiny)
    velocity, lanes = np.zeros(loops), np.arange(loops)
    for k in range(1, count):
        lagged = seen[k].copy()
        back = [y[:, max(k - 1 - law.delay - n, 0)] for n in range(3)]
        lagged[:, 3] = back[0]
        lagged[:, 4] = back[0] - back[1]
        lagged[:, 5] = back[0] - 2.0 * back[1] + back[2]
        one, u[:, k] = law.commands(coefficients, lagged, wanted, u[:, k - 1])
        wanted[1], wanted[0] = wanted[0], np.clip(one, -most * MOST, most * MOST)
        near, far = np.maximum(k - whole, 0), np.maximum(k - whole - 1, 0)
        acting = (1.0 - part) * u[lanes, near] + part * u[lanes, far]
        force = plants.gain * (acting - start[1]) + plants.offset
        force -= plants.stiffness * (y[:, k - 1] - start[0])
        free = decay * velocity + reach * force
        brake = np.maximum(np.abs(free) - reach * plants.coulomb, 0.0)
        after = np.copysign(brake, free)
        y[:, k] = np.clip(y[:, k - 1] + 0.5 * step * (velocity + after), -most, most)
        velocity = np.clip(after, -most / step, most / step)
    return y, u


def _late(plants: PlantModel, step: float) -> tuple[NDArray[np.int_], Vector]:
    """Whole samples of each delay, and what is left as a share of one."""
    whole = np.floor(plants.delay / step).astype(int)
    return whole, plants.delay / step - whole
