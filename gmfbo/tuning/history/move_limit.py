"""How far a real run may move from gains that are known to be good."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.space import Gain, GainSpace

FACTOR = 2.0
"""Most change of a gain in one run, as a factor: what a practitioner dares by hand."""

SHARE = 0.1
"""Most change of a gain in one run, as a share of its range; it counts where it is more."""

LIMIT_TOLD = "a factor of two or a tenth of the range from the nearest gains that settled"
"""The limit in words."""

_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class MoveLimit:
    """Boxes in the unit cube, one around each of the gains known to be good.

    Attributes
    ----------
    low, high : ndarray, shape (k, d)
        Ends of the boxes.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def around(cls, space: GainSpace, good: NDArray[np.float64]) -> Self:
        """Boxes of a factor of two or a tenth of the range, whichever is more, a gain.

        Parameters
        ----------
        space : GainSpace
            Box of the tuned gains.
        good : ndarray, shape (k, d)
            Gains known to be good, in the unit cube.
        """
        low, high = np.maximum(good - SHARE, 0.0), np.minimum(good + SHARE, 1.0)
        values = space.from_unit(good)
        ends = [np.array(values), np.array(values)]
        for column, gain in enumerate(space.gains):
            for row, value in enumerate(values[:, column]):
                reach = _reach(gain, float(value))
                ends[0][row, column], ends[1][row, column] = min(reach), max(reach)
        lower, upper = (space.to_unit(np.clip(end, *space.bounds)) for end in ends)
        return cls(np.minimum(low, lower), np.maximum(high, upper))

    def admits(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points, shape (q, d), lie in one of the boxes, shape (q,)."""
        within = (points[:, None, :] >= self.low - _SLACK) & (
            points[:, None, :] <= self.high + _SLACK
        )
        return np.asarray(np.any(np.all(within, axis=2), axis=1))

    def nearest(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The points, shape (q, d), each moved to the nearest place in a box."""
        moved = np.clip(points[:, None, :], self.low, self.high)
        box = np.argmin(((moved - points[:, None, :]) ** 2).sum(axis=2), axis=1)
        return np.asarray(moved[np.arange(len(points)), box])


def _reach(gain: Gain, value: float) -> list[float]:
    """Values within a factor of two, and the neighbours of a gain that takes single values."""
    reach = [value / FACTOR, value * FACTOR]
    if gain.steps is not None:
        at = int(np.argmin(np.abs(gain.steps - value)))
        reach += list(gain.steps[max(at - 1, 0) : at + 2])
    return reach
