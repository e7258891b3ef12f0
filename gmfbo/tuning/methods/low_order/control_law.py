"""The controller, read out of runs: a difference equation whose coefficients depend on the gains.

A sampled linear controller computes its command from the last few references, measurements and
commands, by coefficients that are products of gains: Kp (r - y) - Kd (y - y_1) / T_s of a PD law,
k_v k_p (r - y) of a cascade. So each coefficient is a polynomial of the gains, and all of them
follow from one linear least-squares problem over runs at different gains. The twin has the
controller of the axis and runs without noise, which makes that problem exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.methods.low_order.runs import SampledRuns

LAGS = 3
"""References and measurements that a command may depend on: a filtered difference of second order."""

MOST_DEGREE = 3
"""Most gains in a product: k_v k_p k_i of a cascade."""

MOST_ERROR = 0.02
"""Error of the command over its size at which the controller counts as read: a fiftieth is less
than what a change of a gain by the finest step of a grid of 41 does."""

FEATURES = 2 * LAGS + 2

_AT_LIMIT = 1.0 - 1e-6
_HELD_ROWS = 5  # equal largest commands in a run that show a limit


@dataclass(frozen=True, eq=False)
class ControlLaw:
    """Command of the next sample as a weighted sum of what was seen last.

    Attributes
    ----------
    exponents : ndarray of int, shape (m, d)
        Of each gain in each product.
    weights : ndarray, shape (FEATURES, m)
        Of each product in the coefficient of each feature.
    low, high : float
        Limits of the command; infinite where none was met.
    error : float
        RMS error of the command in runs that were not fitted, computed from its own past, over the
        RMS of the command.
    """

    exponents: NDArray[np.int_]
    weights: NDArray[np.float64]
    low: float
    high: float
    error: float

    @property
    def is_read(self) -> bool:
        """Whether the runs are explained by a law of this kind."""
        return self.error <= MOST_ERROR

    @classmethod
    def read(cls, runs: SampledRuns) -> Self:
        """Find the law of the lowest degree that explains runs.

        Parameters
        ----------
        runs : SampledRuns
            Of the twin, at different gains; every fifth is kept back to judge by.
        """
        kept = np.arange(len(runs)) % 5 == 4
        if not kept.any():
            kept[-1] = len(runs) > 1
        fitted = runs.only(np.flatnonzero(~kept))
        judged = runs.only(np.flatnonzero(kept)) if kept.any() else runs
        low, high = _limits(runs)
        best: Self | None = None
        for degree in range(1, MOST_DEGREE + 1):
            exponents = _exponents(runs.gains.shape[1], degree)
            if len(exponents) > len(fitted):
                break
            law = cls(exponents, _weights(fitted, exponents, low, high), low, high, np.inf)
            error = law._error_of(judged)
            if best is None or error < 0.5 * best.error:
                best = cls(exponents, law.weights, low, high, error)
        return best or cls(_exponents(runs.gains.shape[1], 0), np.zeros((FEATURES, 1)), low, high, np.inf)

    def coefficients(self, gains: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coefficient of each feature, shape (L, FEATURES), at gains of shape (L, d).

        Parameters
        ----------
        gains : ndarray, shape (L, d)
            As shares of the largest value of each gain.
        """
        return _products(gains, self.exponents) @ self.weights.T

    def _error_of(self, runs: SampledRuns) -> float:
        """Error of the command in its own past, given the measurements."""
        coefficients, count = self.coefficients(runs.gains), runs.time.size
        found = np.array(runs.command)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(LAGS, count):
                features = features_at(runs.reference, runs.measured, found, k)
                found[:, k] = np.clip((coefficients * features).sum(axis=1), self.low, self.high)
            size = float(np.sqrt(np.mean(runs.command**2)))
            error = float(np.sqrt(np.mean((found - runs.command) ** 2)))
        if not np.isfinite(error):
            return np.inf
        return error / size if size > 0.0 else 0.0


def features_at(
    reference: NDArray[np.float64],
    measured: NDArray[np.float64],
    command: NDArray[np.float64],
    k: int,
) -> NDArray[np.float64]:
    """What the command in force just before instant k was computed from, shape (L, FEATURES).

    Values, first and second differences of reference and measurement, value and difference of the
    command: neighbouring samples as they are would be nearly the same feature.

    Parameters
    ----------
    reference, measured, command : ndarray, shape (L, n)
        Up to instant k - 1.
    k : int
        At least `LAGS`.
    """
    r, y, u = reference, measured, command
    return np.stack(
        [
            r[:, k - 1],
            r[:, k - 1] - r[:, k - 2],
            r[:, k - 1] - 2.0 * r[:, k - 2] + r[:, k - 3],
            y[:, k - 1],
            y[:, k - 1] - y[:, k - 2],
            y[:, k - 1] - 2.0 * y[:, k - 2] + y[:, k - 3],
            u[:, k - 1],
            u[:, k - 1] - u[:, k - 2],
        ],
        axis=1,
    )


def _exponents(gains: int, degree: int) -> NDArray[np.int_]:
    rows = [
        np.bincount(np.array(chosen, dtype=int), minlength=gains)
        for count in range(degree + 1)
        for chosen in combinations_with_replacement(range(gains), count)
    ]
    return np.array(rows, dtype=int).reshape(-1, gains)


def _products(gains: NDArray[np.float64], exponents: NDArray[np.int_]) -> NDArray[np.float64]:
    return np.asarray(np.prod(gains[:, None, :] ** exponents, axis=2))


def _limits(runs: SampledRuns) -> tuple[float, float]:
    """Largest commands, where several samples in a row have the same."""
    ends = []
    for sign in (-1.0, 1.0):
        values = sign * runs.command
        most = float(values.max())
        near = values >= most - (1.0 - _AT_LIMIT) * abs(most)
        moved = float(np.ptp(runs.command)) > 0.0 and most != sign * float(runs.command[0, 0])
        held = bool(moved and near.sum(axis=1).max() >= _HELD_ROWS)
        ends.append(sign * most if held else sign * np.inf)
    return ends[0], ends[1]


def _weights(
    runs: SampledRuns, exponents: NDArray[np.int_], low: float, high: float
) -> NDArray[np.float64]:
    """Least squares over all rows in which nothing was limited, run by run compressed by QR."""
    products, blocks, targets = _products(runs.gains, exponents), [], []
    size = float(np.sqrt(np.mean(runs.command**2))) or 1.0
    margin = (1.0 - _AT_LIMIT) * size
    for row in range(len(runs)):
        one = runs.only(np.array([row]))
        u = one.command[0]
        free = (u > low + margin) & (u < high - margin)
        rows = np.flatnonzero(free[LAGS:] & free[LAGS - 1 : -1] & free[LAGS - 2 : -2]) + LAGS
        if not rows.size:
            continue
        lagged = [features_at(one.reference, one.measured, one.command, k)[0] for k in rows]
        table = np.column_stack([np.array(lagged), u[rows]])
        triangle = np.linalg.qr(table, mode="r")
        blocks.append(np.kron(triangle[:, :FEATURES], products[row]))
        targets.append(triangle[:, FEATURES])
    if not blocks:
        return np.zeros((FEATURES, len(exponents)))
    matrix, target = np.vstack(blocks), np.concatenate(targets)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    found, *_ = np.linalg.lstsq(matrix / scale, target, rcond=1e-11)
    return np.asarray((found / scale).reshape(FEATURES, len(exponents)))
