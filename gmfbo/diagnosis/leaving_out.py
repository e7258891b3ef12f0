"""Linear fits on all groups but one, and what they leave in the one that they never saw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.misfit import Blocks

_RIDGE = 1e-8  # of each diagonal element: a direction that is not excited stays where it is


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of each group: residual r, columns A, change d minimises |r - A'd|^2.

    Attributes
    ----------
    matrix : ndarray, shape (n_groups, n, n)
        A A' of each group.
    vector : ndarray, shape (n_groups, n)
        A r of each group.
    square : ndarray, shape (n_groups,)
        r'r of each group.
    """

    matrix: NDArray[np.float64]
    vector: NDArray[np.float64]
    square: NDArray[np.float64]

    def only(self, columns: Sequence[int]) -> Normal:
        """Return the equations of some of the columns."""
        chosen = np.asarray(columns, dtype=int)
        return Normal(
            self.matrix[:, chosen[:, None], chosen[None, :]], self.vector[:, chosen], self.square
        )

    def solution(self) -> NDArray[np.float64]:
        """Best change on all groups, shape (n,)."""
        return _solve(self.matrix.sum(axis=0), self.vector.sum(axis=0))

    def left_out(self) -> NDArray[np.float64]:
        """Square that remains in each group after a fit on all others, shape (n_groups,)."""
        if len(self.square) == 1:
            change = self.solution()[None]
        else:
            matrix = self.matrix.sum(axis=0) - self.matrix
            vector = self.vector.sum(axis=0) - self.vector
            change = np.array([_solve(m, v) for m, v in zip(matrix, vector, strict=True)])
        return self._after(change)

    def fitted(self) -> NDArray[np.float64]:
        """Square that remains in each group after a fit on all, shape (n_groups,)."""
        return self._after(np.repeat(self.solution()[None], len(self.square), axis=0))

    def _after(self, change: NDArray[np.float64]) -> NDArray[np.float64]:
        linear = np.einsum("gi,gi->g", change, self.vector)
        quadratic = np.einsum("gi,gij,gj->g", change, self.matrix, change)
        remains: NDArray[np.float64] = self.square - 2.0 * linear + quadratic
        return remains


def normal_equations(residual: Blocks, columns: Blocks, groups: Sequence[int]) -> Normal:
    """Sum the windows of each group.

    Parameters
    ----------
    residual : Blocks
        Shape (n_residuals,) a window.
    columns : Blocks
        Shape (n, n_residuals) a window.
    groups : sequence of int
        Group of each window, from 0.
    """
    n, count = len(columns[0]), max(groups) + 1
    matrix, vector, square = np.zeros((count, n, n)), np.zeros((count, n)), np.zeros(count)
    for r, a, g in zip(residual, columns, groups, strict=True):
        matrix[g] += a @ a.T
        vector[g] += a @ r
        square[g] += r @ r
    return Normal(matrix, vector, square)


def _solve(matrix: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    size = np.where(size > 0.0, size, 1.0)
    scaled = matrix / np.outer(size, size) + _RIDGE * np.eye(len(size))
    solution: NDArray[np.float64] = np.linalg.solve(scaled, vector / size) / size
    return solution
