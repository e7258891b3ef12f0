"""The box of gains that tuning may move, and its map to the unit cube."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from gmfbo.errors import InputError, did_you_mean

SAME_POINT = 1e-6
"""Distance in the unit cube within which gains are the same: a simulator's repeat tells nothing."""

SAME_GAIN = 1e-6
"""Relative difference up to which two values of a gain are the same: digits of a text file."""


def same_gain(one: float, other: float) -> bool:
    """Whether two values of a gain are the same."""
    return bool(np.isclose(one, other, rtol=SAME_GAIN))


@dataclass(frozen=True)
class Gain:
    """One gain: an FMU parameter and the range it may take.

    Attributes
    ----------
    name : str
        FMU parameter.
    low, high : float
        Bounds [the parameter's unit].
    scale : {"linear", "log"}
        Whether the range is searched by its values or by their logarithm.
    integer : bool
        Whether only whole numbers are allowed.
    values : tuple of float
        The only values allowed, ascending; empty where the whole range is.
    """

    name: str
    low: float
    high: float
    scale: Literal["linear", "log"] = "linear"
    integer: bool = False
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise InputError(
                f"gain '{self.name}': expected finite bounds with low < high, "
                f"got [{self.low}, {self.high}]"
            )
        if self.scale == "log" and self.low <= 0.0:
            raise InputError(
                f"gain '{self.name}': a log scale needs a positive lower bound, got {self.low}"
            )

    @property
    def steps(self) -> NDArray[np.float64] | None:
        """All values that the gain may take, ascending; None where they are continuous."""
        if self.values:
            return np.array(self.values)
        if self.integer:
            return np.arange(np.ceil(self.low), np.floor(self.high) + 1.0)
        return None


@dataclass(frozen=True)
class GainSpace:
    """A box of `d` gains; points are arrays of shape (..., d) in the order of `gains`.

    Attributes
    ----------
    gains : tuple of Gain
        The axes of the box.
    """

    gains: tuple[Gain, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the gains, in order."""
        return tuple(gain.name for gain in self.gains)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Bounds, shape (2, d)."""
        return np.array([[g.low for g in self.gains], [g.high for g in self.gains]])

    def __len__(self) -> int:
        return len(self.gains)

    def to_unit(self, points: ArrayLike) -> NDArray[np.float64]:
        """Map points of the box, shape (..., d), to the unit cube.

        Parameters
        ----------
        points : array_like, shape (..., d)
            In the order of `gains` [unit of each].
        """
        low, high = self._warped_bounds()
        return (self._warp(np.asarray(points, dtype=float)) - low) / (high - low)

    def from_unit(self, unit: ArrayLike) -> NDArray[np.float64]:
        """Map the unit cube, shape (..., d), to the box; outside is clipped, integers rounded.

        Parameters
        ----------
        unit : array_like, shape (..., d)
            Points of the unit cube.
        """
        low, high = self._warped_bounds()
        points = self._unwarp(low + np.clip(np.asarray(unit, dtype=float), 0.0, 1.0) * (high - low))
        for column, gain in enumerate(self.gains):
            if gain.steps is not None:
                points[..., column] = self._nearest_step(gain, points[..., column])
            # exp(log(high)) may miss the bound by a rounding error
            points[..., column] = np.clip(points[..., column], gain.low, gain.high)
        return points

    def latin_hypercube(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw a Latin hypercube of `count` points of the box, shape (count, d).

        Parameters
        ----------
        count : int
            Points; may be 0.
        rng : numpy.random.Generator
            Source of randomness.
        """
        if count == 0:
            return np.empty((0, len(self)))
        return self.from_unit(qmc.LatinHypercube(d=len(self), rng=rng).random(count))

    def point(self, gains: Mapping[str, float] | Sequence[float]) -> NDArray[np.float64]:
        """Point, shape (d,), from values by name or in order.

        Parameters
        ----------
        gains : mapping of str to float, or sequence of float
            One value a gain [unit of each].

        Raises
        ------
        InputError
            A gain is missing, unknown, or the number of values is not d.
        """
        if not isinstance(gains, Mapping):
            values = np.asarray(gains, dtype=float)
            if values.shape != (len(self),):
                raise InputError(
                    f"expected {len(self)} gains ({', '.join(self.names)}), "
                    f"got shape {values.shape}"
                )
            return values
        for name in gains:
            if name not in self.names:
                raise InputError(f"no gain '{name}'" + did_you_mean(name, self.names))
        for name in self.names:
            if name not in gains:
                raise InputError(f"no value for gain '{name}'; give one for each gain")
        return np.array([gains[name] for name in self.names], dtype=float)

    def named(self, point: ArrayLike) -> dict[str, float]:
        """Values by name from a point of shape (d,).

        Parameters
        ----------
        point : array_like, shape (d,)
            In the order of `gains` [unit of each].
        """
        return dict(zip(self.names, map(float, np.asarray(point)), strict=True))

    @property
    def size(self) -> int | None:
        """Number of points of a box whose gains all take single values; None of any other."""
        steps = [gain.steps for gain in self.gains]
        counts = [len(each) for each in steps if each is not None]
        return int(np.prod(counts)) if len(counts) == len(steps) else None

    def grid(self) -> NDArray[np.float64]:
        """All points of a box whose gains all take single values, shape (size, d)."""
        steps = [gain.steps for gain in self.gains]
        each = [values for values in steps if values is not None]
        return np.stack(np.meshgrid(*each, indexing="ij"), axis=-1).reshape(-1, len(self))

    @staticmethod
    def _nearest_step(gain: Gain, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Nearest allowed values, by the scale on which the gain is searched."""
        steps = gain.steps
        assert steps is not None
        at, to = (np.log(values), np.log(steps)) if gain.scale == "log" else (values, steps)
        return np.asarray(steps[np.argmin(np.abs(np.asarray(at)[..., None] - to), axis=-1)])

    def _warp(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        warped = np.array(points, dtype=float)
        for column, gain in enumerate(self.gains):
            if gain.scale == "log":
                warped[..., column] = np.log(points[..., column])
        return warped

    def _unwarp(self, warped: NDArray[np.float64]) -> NDArray[np.float64]:
        points = np.array(warped, dtype=float)
        for column, gain in enumerate(self.gains):
            if gain.scale == "log":
                points[..., column] = np.exp(warped[..., column])
        return points

    def _warped_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        low, high = self._warp(self.bounds)
        return low, high


def folded(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bring points of shape (..., d) into the unit cube, by reflection at its faces."""
    inside = np.mod(points, 2.0)
    return np.minimum(inside, 2.0 - inside)
