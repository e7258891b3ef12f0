"""Leave-one-group-out linear fits: chi2 in each group by a fit to all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.misfit import Blocks

_RIDGE = 1e-10  # of each diagonal element, against rounding


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
    precision : ndarray, shape (n,)
        Of a weak prior of each change about zero: a parameter excited only in the group left out
        stays at zero change instead of following noise elsewhere.
    """

    matrix: NDArray[np.float64]
    vector: NDArray[np.float64]
    square: NDArray[np.float64]
    precision: NDArray[np.float64]

    def only(self, columns: Sequence[int]) -> Normal:
        """Equations of some of the columns."""
        chosen = np.asarray(columns, dtype=int)
        return Normal(
            self.matrix[:, chosen[:, None], chosen[None, :]],
            self.vector[:, chosen],
            self.square,
            self.precision[chosen],
        )

    def solution(self) -> NDArray[np.float64]:
        """Best change on all groups, shape (n,)."""
        return solve_weakly_bound(
            self.matrix.sum(axis=0), self.vector.sum(axis=0)[:, None], self.precision
        )[:, 0]

    def left_out(self) -> NDArray[np.float64]:
        """chi2 of each group after a fit on all others, shape (n_groups,)."""
        if len(self.square) == 1:
            change = self.solution()[None]
        else:
            matrix, vector = sums_of_others(self.matrix), sums_of_others(self.vector)
            change = np.array(
                [
                    solve_weakly_bound(m, v[:, None], self.precision)[:, 0]
                    for m, v in zip(matrix, vector, strict=True)
                ]
            )
        linear = np.einsum("gi,gi->g", change, self.vector)
        quadratic = np.einsum("gi,gij,gj->g", change, self.matrix, change)
        remains: NDArray[np.float64] = self.square - 2.0 * linear + quadratic
        return remains


def normal_equations(
    residual: Blocks,
    columns: Blocks,
    groups: Sequence[int],
    precision: NDArray[np.float64] | None = None,
) -> Normal:
    """Sum the windows of each group.

    Parameters
    ----------
    residual : Blocks
        Shape (n_residuals,) a window.
    columns : Blocks
        Shape (n, n_residuals) a window.
    groups : sequence of int
        Group of each window, from 0.
    precision : ndarray, shape (n,)
        Of a weak prior of each change; none unless given.
    """
    n, count = len(columns[0]), max(groups) + 1
    matrix, vector, square = np.zeros((count, n, n)), np.zeros((count, n)), np.zeros(count)
    for r, a, g in zip(residual, columns, groups, strict=True):
        matrix[g] += a @ a.T
        vector[g] += a @ r
        square[g] += r @ r
    return Normal(matrix, vector, square, np.zeros(n) if precision is None else precision)


def sums_of_others(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum over all groups but one, for each; a group may outweigh all others by 1e12.

    Parameters
    ----------
    values : ndarray, shape (n_groups, ...)
        Of each group.
    """
    count = len(values)
    return np.array([values[[j for j in range(count) if j != g]].sum(axis=0) for g in range(count)])


def solve_weakly_bound(
    matrix: NDArray[np.float64], right: NDArray[np.float64], precision: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Solve normal equations under a weak prior about zero, scaled against rounding.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Symmetric.
    right : ndarray, shape (n, m)
        Right sides.
    precision : ndarray, shape (n,)
        Of the prior.
    """
    bound = matrix + np.diag(precision)
    size = np.sqrt(np.maximum(np.diag(bound), 0.0))
    size = np.where(size > 0.0, size, 1.0)
    scaled = bound / np.outer(size, size) + _RIDGE * np.eye(len(size))
    solution: NDArray[np.float64] = np.linalg.solve(scaled, right / size[:, None]) / size[:, None]
    return solution
