"""Priors of free quantities, in coordinates in which signals are nearly linear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.numbers import FIXED_SPREAD, SIZE_SHARE
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis

Array = NDArray[np.float64]

_WIDE = 1.5  # times: a narrower positive range is as good in the values as in their logarithms


@dataclass(frozen=True)
class Prior:
    """Prior of one free quantity, in its own coordinate u.

    Attributes
    ----------
    low, high : float
        Bounds of the value.
    logarithmic : bool
        Whether u is the value's logarithm.
    kind : str
        `normal`, `cauchy` or `uniform` in u.
    centre, spread : float
        Of a normal prior; `spread` is the scale of a Cauchy prior.
    """

    low: float
    high: float
    logarithmic: bool
    kind: str
    centre: float
    spread: float

    def to_u(self, value: float) -> float:
        """Coordinate of a value."""
        return float(np.log(value)) if self.logarithmic else float(value)

    def to_value(self, u: float) -> float:
        """Value at a coordinate."""
        return float(np.exp(u)) if self.logarithmic else float(u)

    @property
    def bounds(self) -> tuple[float, float]:
        """Of the coordinate."""
        return self.to_u(self.low), self.to_u(self.high)

    def log_density(self, u: float) -> float:
        """[nats] Normalised over the bounds, but for what of a normal prior lies beyond them."""
        if self.kind == "uniform":
            low, high = self.bounds
            return -float(np.log(high - low))
        z = (u - self.centre) / self.spread
        if self.kind == "normal":
            return float(-0.5 * z**2 - np.log(self.spread * np.sqrt(2.0 * np.pi)))
        halves = 2.0 if self.low >= 0.0 else 1.0
        return float(-np.log1p(z**2) - np.log(self.spread * np.pi / halves))

    def slope(self, u: float) -> float:
        """Derivative of the negative log density."""
        if self.kind == "uniform":
            return 0.0
        z = (u - self.centre) / self.spread
        return float(
            z / self.spread if self.kind == "normal" else 2.0 * z / (1 + z**2) / self.spread
        )

    def curvature(self, u: float) -> float:
        """Of a parabola that touches the negative log density there and lies above it.

        A uniform prior has that of a normal one of its variance, so that a quantity which the
        recordings do not show costs and gains nothing.
        """
        if self.kind == "uniform":
            low, high = self.bounds
            return 12.0 / (high - low) ** 2
        if self.kind == "normal":
            return self.spread**-2
        z = (u - self.centre) / self.spread
        return float(2.0 / (1.0 + z**2) / self.spread**2)


def bounds_of(priors: Sequence[Prior]) -> Array:
    """Ends of the coordinates, shape (p, 2)."""
    return np.array([p.bounds for p in priors]).reshape(-1, 2)


def inside(priors: Sequence[Prior], u: Array) -> Array:
    """Coordinates moved strictly between their ends, shape (p,)."""
    ends = bounds_of(priors)
    margin = 1e-6 * (ends[:, 1] - ends[:, 0])
    return np.clip(u, ends[:, 0] + margin, ends[:, 1] - margin)


def coordinates_of(priors: Sequence[Prior], values: Array) -> Array:
    """Coordinates of values, shape (p,)."""
    return np.array([p.to_u(float(v)) for p, v in zip(priors, values, strict=True)])


def values_at(priors: Sequence[Prior], u: Array) -> Array:
    """Values at coordinates, shape (p,)."""
    return np.array([p.to_value(float(v)) for p, v in zip(priors, u, strict=True)])


def own_values(
    priors: Sequence[Prior], names: Sequence[str], u: Array, own: Array
) -> list[dict[str, float]]:
    """By recording, the values of quantities that have own parts; empty where none has.

    Parameters
    ----------
    priors : sequence of Prior
        Of p free quantities.
    names : sequence of str
        Of these.
    u : ndarray, shape (p,)
        Common values, in the coordinates of the priors.
    own : ndarray, shape (n_recordings, p)
        Beside them.
    """
    shown = [int(i) for i in np.flatnonzero(np.any(own != 0.0, axis=0))]
    if not shown:
        return []
    ends = bounds_of(priors)
    inside = np.clip(u + own, ends[:, 0], ends[:, 1])
    return [{names[i]: priors[i].to_value(float(row[i])) for i in shown} for row in inside]


def priors_of(hypothesis: Hypothesis, freed: Sequence[str]) -> tuple[Prior, ...]:
    """Priors of the free quantities of a hypothesis, in the order of its names.

    Parameters
    ----------
    hypothesis : Hypothesis
        Uncertain parameters, freed fixed ones among them, and effects.
    freed : sequence of str
        Names of the fixed parameters that it frees.
    """
    made = []
    for uncertain in hypothesis.setting.uncertain:
        low, high, nominal = uncertain.low, uncertain.high, uncertain.nominal
        if uncertain.name in freed:
            centre = float(np.log(nominal)) if nominal > 0.0 else nominal
            spread = FIXED_SPREAD if nominal > 0.0 else FIXED_SPREAD * abs(nominal)
            made.append(Prior(low, high, nominal > 0.0, "normal", centre, spread))
            continue
        logarithmic = low > 0.0 and high > _WIDE * low
        ends = (np.log(low), np.log(high)) if logarithmic else (low, high)
        centre, spread = 0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]) / np.sqrt(12.0)
        made.append(Prior(low, high, logarithmic, "normal", float(centre), float(spread)))
    for candidate in hypothesis.effects:
        limits = candidate.law.bounds(hypothesis.setting.excitation)
        for parameter in candidate.parameters:
            low, high = map(float, limits[parameter.name])
            is_line = parameter.name.startswith("wavenumber")
            made.append(
                Prior(low, high, False, "uniform", 0.0, 0.0) if is_line else _of_law(low, high)
            )
    return tuple(made)


def _of_law(low: float, high: float) -> Prior:
    """Sizes are half-Cauchy or Cauchy about zero, times and stiffnesses log-uniform.

    Lines are uniform over all that an encoder shows: a search has looked at all of them.
    """
    if low > 0.0:
        return Prior(low, high, high > _WIDE * low, "uniform", 0.0, 0.0)
    return Prior(low, high, False, "cauchy", 0.0, SIZE_SHARE * max(high, -low))
