"""Observations of the surrogate: points, sources and objective values.

Only here a source gets its number, and the objective its sign and scale: g is minimised, its sign
is never changed, and the model standardises it by the mean and standard deviation of all
observations (`Observations.outcome_transform`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from botorch.models.transforms.outcome import Standardize
from numpy.typing import ArrayLike, NDArray

from gmfbo.correction.torch_setup import DTYPE
from gmfbo.errors import InputError, did_you_mean

# Value of the source column. The paper's s is 1 for the real axis and 0 for the twin; the
# corrected twin lies between, at a place that the kernel decides.
IS1 = 1.0
IS2 = 0.0
IS3 = 0.5
SOURCE_COLUMN = {"IS1": IS1, "IS2": IS2, "IS3": IS3}


def source_column(name: str) -> float:
    """Value of the source column for `IS1`, `IS2` or `IS3`.

    Raises
    ------
    InputError
        There is no such source.
    """
    if name not in SOURCE_COLUMN:
        raise InputError(f"no information source '{name}'" + did_you_mean(name, SOURCE_COLUMN))
    return SOURCE_COLUMN[name]


def with_source(points: ArrayLike, source: str) -> torch.Tensor:
    """Inputs of the surrogate, shape (m, d + 1): points of shape (m, d) and the source column."""
    array = np.atleast_2d(np.asarray(points, dtype=float))
    column = np.full((len(array), 1), source_column(source))
    return torch.tensor(np.hstack([array, column]), dtype=DTYPE)


@dataclass(frozen=True, eq=False)
class Observations:
    """Objective values at points of the unit cube, each from one source.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        Gains scaled to the unit cube.
    sources : tuple of str, length n
        `IS1` (real axis), `IS2` (twin) or `IS3` (twin corrected by the trajectory process).
    values : ndarray, shape (n,)
        Objective g, to be minimised.
    extra : ndarray, shape (n,), optional
        [g^2] Extra noise variance of a row, for runs from before the plant changed. None is
        zero.
    """

    points: NDArray[np.float64]
    sources: tuple[str, ...]
    values: NDArray[np.float64]
    extra: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        points = np.array(self.points, dtype=float)
        values = np.array(self.values, dtype=float)
        if points.ndim != 2 or len(points) == 0:
            raise InputError(f"expected points of shape (n, d) with n > 0, got {points.shape}")
        if values.shape != (len(points),) or len(self.sources) != len(points):
            raise InputError(
                f"expected {len(points)} values and sources, one a point, "
                f"got {values.shape} values and {len(self.sources)} sources"
            )
        if not (np.all(np.isfinite(points)) and np.all(np.isfinite(values))):
            raise InputError("points or values hold NaN or infinity; price a failed run first")
        if points.min() < -1e-9 or points.max() > 1.0 + 1e-9:
            raise InputError(
                f"expected points in the unit cube, got [{points.min():g}, {points.max():g}]; "
                "scale them with GainSpace.to_unit"
            )
        for name in self.sources:
            source_column(name)
        if self.extra is not None:
            extra = np.array(self.extra, dtype=float)
            if extra.shape != values.shape or not np.all(np.isfinite(extra)) or extra.min() < 0.0:
                raise InputError(
                    f"expected {len(points)} extra variances, each zero or more, got {self.extra}"
                )
            extra.setflags(write=False)
            object.__setattr__(self, "extra", extra)
        points.setflags(write=False)
        values.setflags(write=False)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "sources", tuple(self.sources))

    @classmethod
    def gather(
        cls, rows: Sequence[tuple[ArrayLike, str, float]], extra: Sequence[float] | None = None
    ) -> Observations:
        """Collect rows of (point of shape (d,), source name, objective), and extra variances."""
        points, sources, values = zip(*rows, strict=True)
        return cls(
            np.array([np.asarray(point) for point in points]),
            sources,
            np.array(values),
            np.array(extra) if extra is not None and any(extra) else None,
        )

    def of(self, source: str) -> NDArray[np.bool_]:
        """Mask of the rows of one source, shape (n,)."""
        return np.array([name == source for name in self.sources], dtype=bool)

    def incumbent(self, source: str) -> float | None:
        """Least objective that this source returned; None when it was never run."""
        values = self.values[self.of(source)]
        return float(values.min()) if values.size else None

    def train_X(self) -> torch.Tensor:
        """Points with the source as last column, shape (n, d + 1)."""
        column = np.array([[source_column(name)] for name in self.sources])
        return torch.tensor(np.hstack([self.points, column]), dtype=DTYPE)

    def train_Y(self) -> torch.Tensor:
        """Objective as given, shape (n, 1)."""
        return torch.tensor(self.values, dtype=DTYPE)[:, None]

    def outcome_transform(self) -> Standardize:
        """Standardisation by mean and standard deviation over all rows; undone in posteriors."""
        return Standardize(m=1)

    def __len__(self) -> int:
        return len(self.sources)
