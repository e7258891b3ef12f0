"""Impulse responses estimated from a random binary signal and its answer, by least squares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.sparse.linalg import LinearOperator, lsqr

Array = NDArray[np.float64]

LONGEST_S = 0.5
"""[s] An axis under control has forgotten a push by then."""

_HOLDS = (1, 1, 2, 3, 5, 8, 13)  # steps between switches: slow parts are excited as fast ones are
_SOLVER_STEPS = 300
_FORGOTTEN = 1e-8  # of a kernel's energy


@dataclass(frozen=True, eq=False)
class Sampling:
    """Where the samples of a signal lie on the communication grid.

    Attributes
    ----------
    below : ndarray of int, shape (n,)
        Row at or before each sample.
    share : ndarray, shape (n,)
        Of the way to the next row.
    """

    below: NDArray[np.intp]
    share: Array

    def read(self, columns: Array) -> Array:
        """Values at the samples, shape (..., n), of columns on the grid, shape (..., rows)."""
        low: Array = columns[..., self.below]
        if not self.share.any():
            return low
        high = columns[..., np.minimum(self.below + 1, columns.shape[-1] - 1)]
        return low + self.share * (high - low)

    def spread(self, values: Array, rows: int) -> Array:
        """Transpose of `read`, shape (rows,), of values at the samples, shape (n,)."""
        above = np.minimum(self.below + 1, rows - 1)
        grid = np.bincount(self.below, (1.0 - self.share) * values, minlength=rows)
        more = np.bincount(above, self.share * values, minlength=rows)
        return np.asarray(grid + more, dtype=np.float64)


def sampling(grid: Array, time: Array) -> Sampling:
    """Find samples on the communication grid.

    Parameters
    ----------
    grid : ndarray, shape (rows,)
        [s] Communication points.
    time : ndarray, shape (n,)
        [s] Of the samples; a thousandth of a step off a point counts as at it.
    """
    places = (time - grid[0]) / (grid[1] - grid[0])
    nearest = np.round(places)
    if np.abs(places - nearest).max() < 1e-3:
        places = nearest
    below = np.clip(np.floor(places).astype(np.intp), 0, grid.size - 1)
    return Sampling(below, np.clip(places - below, 0.0, 1.0))


def random_binary(rows: int, rng: np.random.Generator) -> Array:
    """Random signs, each held for a random number of steps, shape (rows,); the first is 0."""
    holds = rng.choice(_HOLDS, rows)
    signs = rng.choice([-1.0, 1.0], rows)
    column: Array = np.repeat(signs, holds)[:rows]
    column[0] = 0.0  # the first value would also act while the twin settles
    return column


def impulse_responses(column: Array, changes: Mapping[str, Array], step: float) -> dict[str, Array]:
    """Kernels that turn an excitation into its answers, all as long as the slowest is seen.

    Parameters
    ----------
    column : ndarray, shape (rows,)
        Excitation, held over each step.
    changes : mapping of str to ndarray, shape (rows,)
        What it changes.
    step : float
        [s]
    """
    taps = int(np.clip(round(LONGEST_S / step), 1, max(1, column.size // 3)))
    kernels = {name: _deconvolved(column, change, taps) for name, change in changes.items()}
    length = max(_remembered(kernel) for kernel in kernels.values())
    return {name: kernel[:length] for name, kernel in kernels.items()}


def _deconvolved(column: Array, change: Array, taps: int) -> Array:
    """Kernel that turns the excitation into the change, by least squares, shape (taps,)."""
    rows = column.size
    length = next_fast_len(rows + taps, real=True)
    spectrum = rfft(column, length)

    def forwards(kernel: Array) -> Array:
        out: Array = irfft(spectrum * rfft(kernel.ravel(), length), length)[:rows]
        return out

    def backwards(values: Array) -> Array:
        out: Array = irfft(np.conj(spectrum) * rfft(values.ravel(), length), length)[:taps]
        return out

    toeplitz = LinearOperator((rows, taps), matvec=forwards, rmatvec=backwards, dtype=np.float64)
    kernel: Array = lsqr(toeplitz, change, atol=1e-9, btol=1e-9, iter_lim=_SOLVER_STEPS)[0]
    return kernel


def _remembered(kernel: Array) -> int:
    """Taps after which next to nothing of a kernel's energy is left."""
    left = np.cumsum(kernel[::-1] ** 2)[::-1]
    return int(np.count_nonzero(left > _FORGOTTEN * left[0])) or 1
