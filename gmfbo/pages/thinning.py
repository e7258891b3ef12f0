"""Thin curves and digits without a visible change: no peak is lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def thinned_rows(columns: Sequence[Array], buckets: int) -> NDArray[np.intp]:
    """Rows with the lowest and highest value of each column in each stretch.

    Parameters
    ----------
    columns : sequence of ndarray, shape (n,)
        Of the same rows; values that are not finite are ignored.
    buckets : int
        Stretches.

    Returns
    -------
    ndarray, shape (m,)
        Rising, both ends among them; all rows where there are few.
    """
    n = columns[0].size
    if n <= 2 * buckets * len(columns):
        return np.arange(n)
    size = -(-n // buckets)
    starts = np.arange(0, n, size)
    kept = [np.array([0, n - 1])]
    for column in columns:
        # Padding of the last stretch is never an extreme; a stretch of NaN keeps its start.
        for sign in (1.0, -1.0):
            judged = np.full(starts.size * size, np.inf)
            judged[:n] = np.where(np.isfinite(column), sign * column, np.inf)
            kept.append(starts + judged.reshape(-1, size).argmin(axis=1))
    return np.unique(np.concatenate(kept))


def few_digits(values: Array, digits: int) -> list[float | None]:
    """Round numbers for JSON; null stands for values that are not finite.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Numbers.
    digits : int
        Significant digits.
    """
    return [float(f"{v:.{digits}g}") if np.isfinite(v) else None for v in values.tolist()]
