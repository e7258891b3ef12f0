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
    low, high : float
        [FMU's unit] Bounds of the FMU.
    """

    name: str
    values: tuple[float, ...]
    spread: float
    low: float = -np.inf
    high: float = np.inf

    def moved(self, steps: Sequence[float]) -> FittedStart:
        """The same start after a step in each recording, within its bounds."""
        pairs = zip(self.values, steps, strict=True)
        values = tuple(float(np.clip(v + s, self.low, self.high)) for v, s in pairs)
        return replace(self, values=values)
