"""Gains that real runs avoid, because a run nearby left the safety envelope."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from gmfbo.tuning.history.move_limit import MoveLimit

Snap = Callable[[NDArray[np.float64]], NDArray[np.float64]]

KEEP_OUT_RADIUS = 0.1
"""RMS distance over the gains, as a share of their ranges: a tenth of each range."""

_CANDIDATES = 1024
_HALVINGS = 20


def _no_points() -> NDArray[np.float64]:
    return np.empty((0, 0))


@dataclass(frozen=True, eq=False)
class KeepOut:
    """Neighbourhoods of unsafe runs, without those of safe real runs.

    A point is kept out if an unsafe run lies within the radius and no safe real run is nearer.
    So the axis overrules a twin that is too cautious, step by step from safe gains on.

    Attributes
    ----------
    unsafe : ndarray, shape (m, d)
        Points of the unit cube at which the axis, or the twin, left the envelope.
    safe : ndarray, shape (n, d)
        Points at which the axis stayed inside.
    moves : MoveLimit or None
        Boxes in which a real run must lie; None where it may lie anywhere.
    """

    unsafe: NDArray[np.float64] = field(default_factory=_no_points)
    safe: NDArray[np.float64] = field(default_factory=_no_points)
    moves: MoveLimit | None = None

    def __bool__(self) -> bool:
        return len(self.unsafe) > 0 or self.moves is not None

    def admits(
        self, points: NDArray[np.float64], radius: float = KEEP_OUT_RADIUS
    ) -> NDArray[np.bool_]:
        """Which points may be run on the axis.

        Parameters
        ----------
        points : ndarray, shape (q, d)
            In the unit cube.
        radius : float
            RMS distance over the gains.

        Returns
        -------
        ndarray of bool, shape (q,)
            True where a real run is allowed.
        """
        near = np.ones(len(points), dtype=bool) if self.moves is None else self.moves.admits(points)
        if len(self.unsafe) == 0 or len(points) == 0:
            return near
        to_unsafe = _nearest(points, self.unsafe)
        to_safe = _nearest(points, self.safe) if len(self.safe) else np.full(len(points), np.inf)
        return np.asarray(near & ((to_unsafe > radius) | (to_safe < to_unsafe)))

    def admitted(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """As `admits`, with a radius that is halved until some point is allowed.

        An entirely unsafe box must not end a study: the points farthest from the unsafe ones are
        then allowed. All are False only where each point is an unsafe run itself.
        """
        radius = KEEP_OUT_RADIUS
        for _ in range(_HALVINGS):
            allowed = self.admits(points, radius)
            if allowed.any():
                return allowed
            radius *= 0.5
        return self.admits(points, 0.0)

    def nearest_admitted(
        self, point: NDArray[np.float64], held: Mapping[int, float], snap: Snap = np.asarray
    ) -> NDArray[np.float64]:
        """The point itself if it is allowed, or the nearest of many allowed points.

        Parameters
        ----------
        point : ndarray, shape (d,)
            In the unit cube.
        held : mapping of int to float
            Columns that must keep their values.
        snap : callable, optional
            Moves points of shape (m, d) to those that can be run, such as integer gains.
        """
        if self.admits(point[None, :])[0] or len(held) == len(point):
            return point
        # The points are the same at each call: a proposal follows from the runs on disk alone.
        cover = qmc.Sobol(d=len(point), rng=0).random(_CANDIDATES)
        for column, value in held.items():
            cover[:, column] = value
        if self.moves is not None:
            cover = self.moves.nearest(np.vstack([point, cover]))
            for column, value in held.items():
                cover[:, column] = value
        cover = snap(cover)
        allowed = cover[self.admitted(cover)]
        if len(allowed) == 0:
            return point
        return np.asarray(allowed[int(np.argmin(_nearest(allowed, point[None, :])))])


def _nearest(points: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """RMS distance over the gains to the nearest of others, shape (q,)."""
    return np.asarray(cdist(points, others).min(axis=1) / np.sqrt(points.shape[1]))
