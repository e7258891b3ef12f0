"""A start of the axis that nobody recorded: in each recording another value, fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class FittedStart:
    """A start that is fitted to each recording.

    Attributes
    ----------
    name : str
        Parameter of the FMU.
    values : tuple of float
        [FMU's unit] By recording.
    spread : float
        [FMU's unit] Standard deviation of its prior: it moves a signal by its range.
    step : float
        [FMU's unit] By which it is moved to see what it does.
    low, high : float
        [FMU's unit] Bounds of the FMU.
    """

    name: str
    values: tuple[float, ...]
    spread: float
    step: float
    low: float = -np.inf
    high: float = np.inf

    def sizes(self) -> list[float]:
        """[FMU's unit] Of a step from each value, within the bounds."""
        step = min(self.step, 0.3 * (self.high - self.low))
        return [-step if value + step > self.high else step for value in self.values]

    @property
    def at_bound(self) -> list[bool]:
        """Whether each value is one of the FMU's bounds."""
        return [value in (self.low, self.high) for value in self.values]

    def moved(self, steps: Sequence[float]) -> FittedStart:
        """The same start after a step in each recording, within its bounds."""
        pairs = zip(self.values, steps, strict=True)
        values = tuple(float(np.clip(v + s, self.low, self.high)) for v, s in pairs)
        return replace(self, values=values)
