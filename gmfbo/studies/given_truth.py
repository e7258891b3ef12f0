"""Noise-free truth of a plant that cannot be run all over the box: a table of the user."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from gmfbo.errors import StudyFileError
from gmfbo.space import GainSpace

LATE_ERROR = "late_error"
"""Column with the late error of a row over what counts as settled; above 1 it did not settle."""

LEAST_ROWS = 10


@dataclass(frozen=True, eq=False)
class GivenTruth:
    """Noise-free metrics of a plant over the box; m points, d gains.

    Attributes
    ----------
    space : GainSpace
        Box of the tuned gains.
    points : ndarray, shape (m, d)
        In the unit cube.
    metrics : dict of str to ndarray, shape (m,)
        Each metric [% or s]; infinite where a run failed or did not settle.
    """

    space: GainSpace
    points: NDArray[np.float64]
    metrics: dict[str, NDArray[np.float64]]

    @classmethod
    def read(cls, path: Path, space: GainSpace, metrics: frozenset[str]) -> Self:
        """Read the table that `[compare] truth` names.

        Parameters
        ----------
        path : Path
            CSV with one head line: a column a tuned gain, a column a metric.
        space : GainSpace
            Box of the tuned gains.
        metrics : frozenset of str
            Metrics that count.

        Raises
        ------
        StudyFileError
            It cannot be read, lacks a column, holds no number, or leaves the box.
        """
        columns = _columns(path)
        lacking = sorted({*space.names, *metrics} - columns.keys())
        if lacking:
            raise StudyFileError(
                f"[compare] truth: '{path}' has no column {', '.join(lacking)}; expected one for "
                "each tuned gain and each metric that counts"
            )
        gains = np.stack([columns[name] for name in space.names], axis=1)
        low, high = space.bounds
        slack = 1e-6 * (high - low)
        if not np.all(np.isfinite(gains) & (gains >= low - slack) & (gains <= high + slack)):
            raise StudyFileError(
                f"[compare] truth: '{path}' holds gains outside the box of the study; make it "
                "again for this box"
            )
        late = columns.get(LATE_ERROR, np.zeros(len(gains)))
        found = {name: np.where(late > 1.0, np.inf, columns[name]) for name in metrics}
        found = {name: np.where(np.isnan(one), np.inf, one) for name, one in found.items()}
        return cls(space, space.to_unit(np.clip(gains, low, high)), found)

    def at(self, points: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Metrics at the nearest rows.

        Parameters
        ----------
        points : array_like, shape (n, d)
            In the unit cube.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Of that row: no gains are better than the best row.
        """
        _, rows = KDTree(self.points).query(np.asarray(points, dtype=float))
        return {name: values[rows] for name, values in self.metrics.items()}


def _columns(path: Path) -> dict[str, NDArray[np.float64]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            names, *rows = list(csv.reader(file))
        table = np.array(rows, dtype=float)
        if table.shape != (len(rows), len(names)) or len(rows) < LEAST_ROWS:
            raise ValueError(f"{len(rows)} rows")
    except OSError as error:
        raise StudyFileError(
            f"[compare] truth: '{path}' cannot be read ({error.strerror or error})"
        ) from None
    except ValueError:
        raise StudyFileError(
            f"[compare] truth: '{path}': expected a CSV of numbers with one head line and at "
            f"least {LEAST_ROWS} rows"
        ) from None
    return dict(zip((name.strip() for name in names), table.T, strict=True))
