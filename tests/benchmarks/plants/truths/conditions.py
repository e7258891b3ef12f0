"""What differs from one run of a plant to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Conditions:
    """Friction, inertia and noise of one run.

    Attributes
    ----------
    friction : float
        Factor of the plant's friction; 1 is its mean.
    rng : numpy.random.Generator or None
        Draws the measurement noise; None makes a run without noise.
    inertia : float
        Factor of what is moved, or heated.
    level : float
        Factor of the measurement noise.
    """

    friction: float = 1.0
    rng: np.random.Generator | None = None
    inertia: float = 1.0
    level: float = 1.0

    def noise(self, deviation: float, rows: int) -> Vector:
        """White noise, shape (rows,), of this standard deviation; zeros without noise.

        Parameters
        ----------
        deviation : float
            [unit of the signal]
        rows : int
            Samples.
        """
        if self.rng is None:
            return np.zeros(rows)
        return np.asarray(self.level * deviation * self.rng.standard_normal(rows))


QUIET = Conditions()
"""Mean friction, no noise: the conditions by which gains are judged."""


class Fallen(ArithmeticError):
    """The plant left the region in which it can be controlled; counts as a failed run."""
