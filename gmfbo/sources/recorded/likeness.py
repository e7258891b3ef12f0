"""How far a recorded signal has the shape, size and sign of an expected one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SAME_SHAPE = 0.9
"""Correlation from which two signals are one shape: then four fifths are explained."""

MIDWAY = 0.5
"""Share of the simulated motion, midway between an axis that follows and one that does not."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Likeness:
    """How a recorded signal follows an expected one.

    Attributes
    ----------
    gain : float
        Recorded over expected, by regression [1].
    correlation : float
        Of both, as they are.
    shifted, near : float
        Highest correlation at any shift by up to half the recording, and up to a tenth of it:
        no column of a usable recording is later than that.
    motion : float
        Standard deviation of the recorded signal over that of the expected one [1].
    """

    gain: float
    correlation: float
    shifted: float
    near: float
    motion: float

    @property
    def is_flipped(self) -> bool:
        """Whether it has the opposite sign; a sine that is half a period late has not."""
        return self.correlation <= -SAME_SHAPE and self.shifted < -self.correlation

    @property
    def is_far_in_size(self) -> bool:
        """Whether its size is nearer to the next unit's, 2 pi times as large, than to its own."""
        return abs(math.log(self.motion)) > 0.5 * math.log(2.0 * math.pi)

    @property
    def is_unrelated(self) -> bool:
        """Whether it moves, and has less than half of the expected motion in it at any shift."""
        return self.motion >= MIDWAY > max(self.shifted, self.shifted * self.motion)

    @property
    def may_be_unrelated(self) -> bool:
        """Whether it moves, and little of it is like the expected motion at a usual shift."""
        return self.motion >= MIDWAY > self.near


def likeness(recorded: Array, expected: Array) -> Likeness | None:
    """Compare two signals without their means; None where one of them does not move.

    Parameters
    ----------
    recorded, expected : ndarray, shape (n,)
        Rows that both have.
    """
    a, b = recorded - recorded.mean(), expected - expected.mean()
    own, other, both = float(a @ a), float(b @ b), float(a @ b)
    least = 1e-12 * float(np.abs(expected).max() ** 2) * expected.size
    if own <= 0.0 or other <= least:
        return None
    size = math.sqrt(own) * math.sqrt(other)
    padded = 2 * a.size
    spectrum = np.fft.rfft(a, padded) * np.conj(np.fft.rfft(b, padded))
    together = np.fft.irfft(spectrum, padded)
    together = np.roll(together, a.size)[:padded] / size

    def highest(rows: int) -> float:
        return float(together[a.size - rows : a.size + rows + 1].max())

    shifted, near = highest(a.size // 2), highest(a.size // 10)
    return Likeness(both / other, both / size, shifted, near, math.sqrt(own / other))
