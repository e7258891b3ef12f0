"""A check that a right twin passes sample by sample: residual and noise of one part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BLOCK_S = 0.03
"""[s] Averaging time of a residual, shorter than a reversal or a pulse."""

FAILS_ABOVE = 3.0
"""Mean square of block scores above which a parity fails; it is one for a right twin."""

_FARTHEST = 2.0  # standard deviations of a nuisance


@dataclass(frozen=True, eq=False)
class Parity:
    """Residual of one part of the loop in every recording.

    Attributes
    ----------
    columns : tuple of ndarray, shape (rows,)
        [unit] On the communication grid of each recording; NaN where it is not scored.
    grids : tuple of ndarray, shape (rows,)
        [s] Those grids.
    noise : float
        [unit] Standard deviation of the mean of a block in a twin that is right.
    unit : str
        Of the residual, as the FMU spells it; empty where it is unknown.
    """

    columns: tuple[NDArray[np.float64], ...]
    grids: tuple[NDArray[np.float64], ...]
    noise: float
    unit: str = ""

    def scores(self, record: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Start of each block [s] and the mean in it, in standard deviations of noise."""
        starts, means = block_means(self.grids[record], self.columns[record])
        return starts, means / self.noise

    @property
    def excess(self) -> float:
        """Mean square of all scores; about one where the twin is right."""
        scores = [self.scores(k)[1] for k in range(len(self.columns))]
        together = np.concatenate(scores)
        return float(np.mean(together**2)) if together.size else 0.0

    @property
    def fails(self) -> bool:
        """Whether this part of the loop differs from the twin's."""
        return self.excess > FAILS_ABOVE


def block_rows(grid: NDArray[np.float64]) -> int:
    """Rows of one block, shape (rows,) of times [s] given."""
    step = float(grid[-1] - grid[0]) / max(1, grid.size - 1)
    return max(1, round(BLOCK_S / step))


def block_means(
    grid: NDArray[np.float64], column: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Start [s] and mean of each whole block, those with NaN left out.

    Parameters
    ----------
    grid : ndarray, shape (rows,)
        [s]
    column : ndarray, shape (rows,)
        Values.
    """
    rows = block_rows(grid)
    count = column.size // rows
    means = column[: count * rows].reshape(count, rows).mean(axis=1)
    known = np.isfinite(means)
    return grid[: count * rows : rows][known], means[known]


def block_spread(
    grids: Sequence[NDArray[np.float64]], columns: Sequence[NDArray[np.float64]]
) -> float:
    """Root mean square of the block means of columns that should be zero.

    Parameters
    ----------
    grids : sequence of ndarray, shape (rows,)
        [s]
    columns : sequence of ndarray, shape (rows,)
        Values.
    """
    means = [block_means(g, c)[1] for g, c in zip(grids, columns, strict=True)]
    together = np.concatenate(means)
    return float(np.sqrt(np.mean(together**2))) if together.size else 0.0


def fast_noise(column: NDArray[np.float64]) -> float:
    """Standard deviation of white noise with the steps of a column, shape (rows,).

    The median passes over the few steps at which something happens.
    """
    steps = np.abs(np.diff(column[np.isfinite(column)]))
    return float(np.median(steps)) / (0.6745 * np.sqrt(2.0)) if steps.size else 0.0


def without_nuisances(
    residual: NDArray[np.float64],
    columns: Sequence[NDArray[np.float64]],
    noise: float,
    rows: int = 1,
) -> NDArray[np.float64]:
    """Remove nuisance columns, each one standard deviation of its prior long.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        With NaN where it is not scored.
    columns : sequence of ndarray, shape (n,)
        Changes of it by each nuisance.
    noise : float
        Standard deviation of the residual.
    rows : int
        Of the blocks whose means are fitted.
    """
    count = residual.size // rows
    together = np.column_stack([residual, *columns])
    means = together[: count * rows].reshape(count, rows, -1).mean(axis=1)
    means = means[np.isfinite(means).all(axis=1)] / noise
    target, own = means[:, 0], means[:, 1:]
    sizes = np.linalg.solve(own.T @ own + np.eye(len(columns)), own.T @ target)
    # A large residual would overrule any prior; an error this large is not a nuisance.
    sizes = np.clip(sizes, -_FARTHEST, _FARTHEST)
    return np.asarray(residual - np.column_stack(columns) @ sizes, dtype=np.float64)
