"""The true law fitted to recordings of its own case, with the plant's own equations.

Columns are compared as the twin is compared: in closed loop from the reference, position and
command; of a twin in open loop the position alone, under the recorded command. What a plant in open
loop drifts by is taken off as the oracle does it (`tests/blind/oracle.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.blind.draw.law_coordinates import Coordinates
from tests.blind.draw.noise_of_a_case import driven
from tests.blind.draw.remade import Columns, Remade
from tests.blind.truth import SAMPLE, Diverged, Vector

_ITERATIONS = 5
_HALVINGS = 4
_CLOSE = 1e-6
"""Share of the squares below whose drop a fit has ended."""


@dataclass(frozen=True)
class TrueLaw:
    """The plant of a case with some of its values free.

    Attributes
    ----------
    case : Remade
        What was drawn.
    free : Coordinates
        Zero is the truth.
    """

    case: Remade
    free: Coordinates

    @cached_property
    def shown(self) -> Columns:
        """Columns of the truth without noise."""
        return self.case.clean(self.case.plant)

    def unlike(self, recorded: Columns, x: Vector, chosen: Sequence[int] | None = None) -> Columns:
        """Recorded less simulated, of the chosen recordings, as both are compared.

        Parameters
        ----------
        recorded : list of ndarray, shape (rows, 2) each
            Position and command of these recordings.
        x : ndarray
            Free values.
        chosen : sequence of int, optional
            Which they are; all without it.
        """
        values = self.free.at(x)
        if not self.case.machine.is_open_loop:
            run = self.case.clean(values, chosen)
            return [a - b for a, b in zip(recorded, run, strict=True)]
        compared = self.case.oracle.compared
        return [compared(own[:, :1] - driven(values, own)[:, None]) for own in recorded]

    @cached_property
    def slopes(self) -> list[Vector]:
        """Derivatives of the columns at the truth, shape (rows, n_columns, n_free) each.

        By central differences of runs without noise. They serve for all steps of a fit: where a
        recording tells a value at all, its estimate is so near the truth that they hardly change.
        """
        found: list[list[Vector]] = [[] for _ in self.shown]
        for k, step in enumerate(self.free.steps):
            ahead, behind = np.zeros((2, len(self.free.groups)))
            ahead[k], behind[k] = step, -step
            after, before = (self.unlike(self.shown, x) for x in (ahead, behind))
            for own, a, b in zip(found, after, before, strict=True):
                own.append((b - a) / (2.0 * step))
        columns = 1 if self.case.machine.is_open_loop else 2
        return [
            np.array(own).reshape(-1, len(one), columns).transpose(1, 2, 0)
            for own, one in zip(found, self.shown, strict=True)
        ]

    def starts(self, rows: Sequence[int]) -> list[Vector]:
        """Change of the position in open loop by place and speed at a start, shape (rows, 2) each.

        Parameters
        ----------
        rows : sequence of int
            Of each recording.
        """
        rate = self.case.values["viscous"] / self.case.values["inertia"]
        return [np.column_stack([np.ones(n), np.exp(-rate * SAMPLE * np.arange(n))]) for n in rows]

    def fitted(self, recorded: Columns, chosen: Sequence[int], scales: Sequence[float]) -> Vector:
        """Free values of least squares, from the truth on by damped Gauss-Newton steps.

        Parameters
        ----------
        recorded : list of ndarray, shape (rows, 2) each
            Of the chosen recordings.
        chosen : sequence of int
            Which they are.
        scales : sequence of float
            Of the differences of each column that is compared; the errors that are scored count in
            these too.
        """
        own_starts = self._own_starts([len(one) for one in recorded])
        slopes = np.vstack([_flat(self.slopes[k], scales) for k in chosen])
        slopes = _without(slopes, own_starts)

        def left_at(x: Vector) -> Vector:
            columns = self.unlike(recorded, x, chosen)
            white = np.vstack([_flat(own[:, :, None], scales) for own in columns])
            return _without(white, own_starts)[:, 0]

        x = np.zeros(len(self.free.groups))
        left = left_at(x)
        for _ in range(_ITERATIONS if x.size else 0):
            step = solved(slopes, left)
            for _ in range(_HALVINGS):
                try:
                    new = left_at(x + step)
                except Diverged:
                    new = np.full_like(left, np.inf)
                if new @ new < left @ left:
                    break
                step *= 0.5
            else:
                break
            drop = left @ left - new @ new
            x, left = x + step, new
            if drop < _CLOSE * (left @ left):
                break
        return x

    def _own_starts(self, rows: Sequence[int]) -> list[Vector]:
        """Orthonormal directions of the starts of open loops, as they are compared, else none."""
        if not self.case.machine.is_open_loop:
            return [np.zeros((2 * n, 0)) for n in rows]
        return [np.linalg.qr(self.case.oracle.compared(own))[0] for own in self.starts(rows)]


def _flat(columns: Vector, scales: Sequence[float]) -> Vector:
    """Columns over their scales one below the other: shape (rows n_columns, n) of (rows, ., n)."""
    scaled = columns / np.reshape(scales, (1, -1, 1))
    return np.asarray(scaled.transpose(1, 0, 2).reshape(-1, columns.shape[2]))


def _without(stacked: Vector, directions: Sequence[Vector]) -> Vector:
    """Rows of all recordings without what lies along orthonormal directions of each."""
    parts, at = [], 0
    for own in directions:
        part = stacked[at : at + len(own)]
        parts.append(part - own @ (own.T @ part))
        at += len(own)
    return np.vstack(parts)


def solved(slopes: Vector, left: Vector) -> Vector:
    """Step of least squares; none along what the recordings cannot tell.

    Parameters
    ----------
    slopes : ndarray, shape (n, n_free)
        Derivatives.
    left : ndarray, shape (n,)
        Differences.
    """
    size = np.linalg.norm(slopes, axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(slopes / size, left, rcond=1e-6)[0] / size)
