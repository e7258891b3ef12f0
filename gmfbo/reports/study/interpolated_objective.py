"""Interpolate the cost of one source between its runs, for drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.spatial import ConvexHull, QhullError

from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_roles import Run

Array = NDArray[np.float64]

_ALL_AT_ONCE = 600  # runs; the time of a spline through all grows with their cube
_NEIGHBOURS = 60
_SMOOTHING = 1e-6
_PLANE = 2  # gains whose runs have a hull that is quick to find; of more, their range stands for it
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class InterpolatedObjective:
    """Cost g of twin or axis over the gains: a thin-plate spline through the runs.

    It follows from the stored runs alone. No method depends on it, and it is not the posterior
    of a surrogate.

    Attributes
    ----------
    source : {"IS1", "IS2"}
        The source with runs at more different gains.
    runs : int
        Number of different gains that it interpolates.
    """

    source: str
    runs: int
    _spline: RBFInterpolator
    _sides: Array

    @classmethod
    def of(cls, review: StudyReview) -> Self | None:
        """Interpolate the runs that succeeded.

        Parameters
        ----------
        review : StudyReview
            The study as it is shown.

        Returns
        -------
        InterpolatedObjective or None
            None where there are too few runs.
        """
        runs = {"IS2": review.twin_runs, "IS1": review.real}
        known = {source: _values(review, own) for source, own in runs.items()}
        source = max(known, key=lambda name: len(known[name][0]))
        points, costs = known[source]
        gains = len(review.space)
        if not gains or len(points) < gains + 2:
            return None
        near = None if len(points) <= _ALL_AT_ONCE else _NEIGHBOURS
        try:
            spline = RBFInterpolator(points, costs, smoothing=_SMOOTHING, neighbors=near)
            sides = ConvexHull(points).equations if gains == _PLANE else _range_of(points)
        except (np.linalg.LinAlgError, QhullError):
            return None  # all runs on one line
        return cls(source, len(points), spline, sides)

    def at(self, points: Array) -> Array:
        """Cost g, shape (q,), at points of the unit cube, shape (q, d); NaN beyond its runs.

        Beyond its points a spline goes on at will: a corner that nothing was run in would be the
        best of all.
        """
        costs = np.asarray(self._spline(points), dtype=float)
        beyond = points @ self._sides[:, :-1].T + self._sides[:, -1]
        costs[np.any(beyond > _ROUNDING, axis=1)] = np.nan
        return costs


def _range_of(points: Array) -> Array:
    """Sides of the range of some points: outward normals, then offsets, shape (2 d, d + 1)."""
    axes = np.eye(points.shape[1])
    offsets = np.concatenate([points.min(axis=0), -points.max(axis=0)])
    return np.column_stack([np.concatenate([-axes, axes]), offsets])


def _values(review: StudyReview, runs: Sequence[Run]) -> tuple[Array, Array]:
    """Different points, shape (n, d), and the mean cost at each, shape (n,)."""
    succeeded = [run for run in runs if run.trial.status == "ok"]
    points = review.points(succeeded)
    costs = np.array([run.trial.objective for run in succeeded])
    if not len(points):
        return points, costs
    unique, where = np.unique(points.round(9), axis=0, return_inverse=True)
    where = where.reshape(-1)
    return unique, np.bincount(where, costs) / np.bincount(where)
