"""95 % intervals of a statistic over seeds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.reports.comparison.curves import Spread

DRAWS = 4000

Statistic = Callable[..., NDArray[np.float64]]
"""A function like `numpy.mean`, with an axis."""


class Interval(Spread):
    """A statistic with its 95 % interval, by bootstrap."""

    @classmethod
    def of(cls, sample: ArrayLike, statistic: Statistic) -> Self:
        """Percentile bootstrap (Efron 1979), the same draws each time.

        Parameters
        ----------
        sample : array_like, shape (n,)
            One value a seed.
        statistic : callable
            Such as `numpy.mean`.
        """
        values = np.asarray(sample, dtype=float)
        rows = np.random.default_rng(0).integers(values.size, size=(DRAWS, values.size))
        low, high = np.quantile(statistic(values[rows], axis=1), [0.025, 0.975])
        return cls(float(statistic(values, axis=0)), float(low), float(high))

    def text(self, decimals: int = 1) -> str:
        """Write `value [low, high]`, each with so many decimals."""
        return f"{self.value:.{decimals}f} [{self.low:.{decimals}f}, {self.high:.{decimals}f}]"
