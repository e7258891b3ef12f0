"""Axes of a chart: places of values in the drawing, and labelled ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """A range of values mapped to a stretch of the drawing.

    Attributes
    ----------
    low, high : float
        Ends of the values.
    start, end : float
        Their places in the drawing.
    """

    low: float
    high: float
    start: float
    end: float

    @property
    def log(self) -> bool:
        """Whether equal distances are equal ratios."""
        return False

    @classmethod
    def over(cls, values: Sequence[Array], start: float, end: float, margin: float) -> Axis:
        """Span all finite values and a share of their spread on either side.

        Parameters
        ----------
        values : sequence of ndarray
            Values that have to fit.
        start, end : float
            Where the ends lie in the drawing.
        margin : float
            Share of the spread, dimensionless.
        """
        together = np.concatenate([np.asarray(one, dtype=np.float64) for one in values])
        finite = together[np.isfinite(together)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        # A constant still needs an axis: use its own size as range, or else one.
        spread = (high - low) or abs(high) or 1.0
        if high == low:
            margin = 0.5
        return cls(low - margin * spread, high + margin * spread, start, end)

    def at(self, value: Array | float) -> Array:
        """Place of a value in the drawing."""
        share = (np.asarray(value, dtype=np.float64) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """About four round values: 1, 2 or 5 times a power of ten apart."""
        return _round_values(self.low, self.high)

    def words(self) -> list[str]:
        """What is written at each tick."""
        return _tick_words(self.ticks())


@dataclass(frozen=True)
class LogAxis(Axis):
    """A logarithmic axis; values of zero or less lie at its low end."""

    @property
    def log(self) -> bool:
        return True

    @classmethod
    def over(cls, values: Sequence[Array], start: float, end: float, margin: float) -> LogAxis:
        together = np.concatenate([np.asarray(one, dtype=np.float64) for one in values])
        known = together[np.isfinite(together) & (together > 0.0)]
        exponents = Axis.over([np.log10(known)], start, end, margin)
        return cls(10.0**exponents.low, 10.0**exponents.high, start, end)

    def at(self, value: Array | float) -> Array:
        low, high = np.log10(self.low), np.log10(self.high)
        known = np.maximum(np.asarray(value, dtype=np.float64), self.low)
        return np.asarray(
            self.start + (np.log10(known) - low) / (high - low) * (self.end - self.start)
        )

    def ticks(self) -> list[float]:
        """1, 2 and 5 times powers of ten, or the powers alone where these are too many."""
        powers = np.arange(np.floor(np.log10(self.low)), np.ceil(np.log10(self.high)) + 1.0)
        for steps in ((1.0, 2.0, 5.0), (1.0,)):
            found = [float(step * 10.0**power) for power in powers for step in steps]
            inside = [tick for tick in found if self.low <= tick <= self.high]
            if len(inside) <= 7:
                break
        return inside

    def words(self) -> list[str]:
        return [f"{tick:.4g}" for tick in self.ticks()]


@dataclass(frozen=True)
class CountAxis(Axis):
    """An axis of whole numbers; the margin at its ends is counted in them."""

    @classmethod
    def over(cls, values: Sequence[Array], start: float, end: float, margin: float) -> CountAxis:
        together = np.concatenate(list(values))
        low, high = (float(together.min()), float(together.max())) if together.size else (0.0, 0.0)
        return cls(low - margin, high + margin, start, end)

    def ticks(self) -> list[float]:
        """Whole numbers alone, about six of them."""
        return _round_values(self.low, self.high, least=1.0)


@dataclass(frozen=True)
class NamedAxis(Axis):
    """An axis with a name at each of 0, 1, 2 ...

    Attributes
    ----------
    names : tuple of str
        In order.
    """

    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, names: Sequence[str], start: float, end: float) -> NamedAxis:
        """Place names along a stretch of the drawing, with half a place free at either end.

        Parameters
        ----------
        names : sequence of str
            In order.
        start, end : float
            Where the ends lie in the drawing.
        """
        return cls(-0.5, len(names) - 0.5, start, end, tuple(names))

    def ticks(self) -> list[float]:
        return [float(place) for place in range(len(self.names))]

    def words(self) -> list[str]:
        return list(self.names)


def _tick_words(ticks: Sequence[float]) -> list[str]:
    """As few decimals as tell neighbours apart; powers of ten for very large or small values."""
    largest = max((abs(tick) for tick in ticks), default=0.0)
    if len(ticks) < 2 or not 1e-4 <= largest < 1e6:
        return [f"{tick + 0.0:.4g}" for tick in ticks]
    decimals = max(0, -int(np.floor(np.log10(ticks[1] - ticks[0]) + 1e-9)))
    return [f"{tick + 0.0:.{decimals}f}" for tick in ticks]


def _round_values(low: float, high: float, least: float = 0.0) -> list[float]:
    rough = max((high - low) / 5.0, least)
    power = 10.0 ** np.floor(np.log10(rough))
    step = float(next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return [float(step * k) for k in np.arange(first, last + 1.0)]
