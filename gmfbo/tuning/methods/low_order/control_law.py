"""The controller, read out of runs: a difference equation whose coefficients depend on the gains.

A sampled linear controller computes its command from the last few references, measurements and
commands, by coefficients that are products of gains: Kp (r - y) - Kd (y - y_1) / T_s of a PD law,
k_v k_p (r - y) of a cascade. So each coefficient is a polynomial of the gains, and all of them
follow from one linear least-squares problem over runs at different gains. The twin has the
controller of the axis and runs without noise, which makes that problem exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement, product
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.methods.low_order.runs import SampledRuns

LAGS = 3
"""References and measurements that a command may depend on: differences of second order."""

MOST_DEGREE = 3
"""Most gains in a product: k_v k_p k_i of a cascade."""

MOST_ERROR = 0.02
"""Error of the command over its size at which the controller counts as read: a fiftieth is less
than what a change of a gain by the finest step of a grid of 41 does."""

MOST_DELAY = 8
"""Samples of a bus between controller and drive that are tried."""

FEATURES = 2 * LAGS + 2
"""Features of a command: of reference and measurement, and two of its own past."""

Past = Literal["none", "filter", "integral"]
PASTS: tuple[Past, ...] = ("none", "filter", "integral")
"""What a law may know of its own past, simplest first: nothing, the last command (a filter), or the
last command in full and its change (an integral beside a filter). More freedom would let the plant
of the twin, whose measurement follows from its commands as exactly, pass for the controller."""

_AT_LIMIT = 1.0 - 1e-6
_HELD_ROWS = 3  # equal largest commands that show a limit


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
    delay : int
        Samples by which it is late beside the one that it is held.
    anti_windup : float
        Share of what the limits cut off that an integral loses a sample.
    error : float
        Median over runs that were not fitted: RMS error of the command, computed from its own past,
        over the RMS of the command.
    """

    exponents: NDArray[np.int_]
    weights: NDArray[np.float64]
    low: float
    high: float
    delay: int = 0
    anti_windup: float = 0.0
    error: float = np.inf

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
        fitted = runs.only(np.flatnonzero(~kept))
        judged = runs.only(np.flatnonzero(kept)) if kept.any() else runs
        limits = _limits(runs)
        best, least = (
            cls(_exponents(runs.gains.shape[1], 0), np.zeros((FEATURES, 1)), *limits),
            np.inf,
        )
        for past, degree in product(PASTS, range(1, MOST_DEGREE + 1)):
            exponents = _exponents(runs.gains.shape[1], degree)
            if len(exponents) > len(fitted):
                continue
            late = [_weights(fitted, exponents, limits, d, past) for d in range(MOST_DELAY + 1)]
            delay = int(np.argmin([residual for _, residual in late]))
            weights, residual = late[delay]
            # Below a billionth of the command is rounding, which tells no law from another.
            residual = max(residual, 1e-9 * float(np.sqrt(np.mean(runs.command**2))))
            if residual < 0.1 * least:
                least = residual
                best = cls(exponents, weights, *limits, delay=delay)
        return best._wound_up(judged)

    def _wound_up(self, judged: SampledRuns) -> Self:
        """The same with the rate at which an integral gives way that explains limited runs best.

        No row in which nothing was limited tells of it.
        """
        tried = [replace(self, anti_windup=rate) for rate in (0.0, *np.geomspace(0.01, 1.0, 9))]
        errors = [law._error_of(judged) for law in tried]
        best = int(np.argmin(errors))
        return replace(tried[best], error=errors[best])

    def coefficients(self, gains: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coefficient of each feature, shape (L, FEATURES), at gains of shape (L, d).

        Parameters
        ----------
        gains : ndarray, shape (L, d)
            As shares of the largest value of each gain.
        """
        return _products(gains, self.exponents) @ self.weights.T

    def commands(
        self,
        coefficients: NDArray[np.float64],
        lagged: NDArray[np.float64],
        wanted: NDArray[np.float64],
        command: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Wanted and limited command of one sample, shape (L,) each.

        Parameters
        ----------
        coefficients : ndarray, shape (L, FEATURES)
            See `coefficients`.
        lagged : ndarray, shape (L, 2 LAGS)
            Features of reference and measurement.
        wanted : ndarray, shape (2, L)
            Command before the limits, one and two samples ago.
        command : ndarray, shape (L,)
            Limited command, one sample ago.
        """
        found = np.einsum("lf,lf->l", coefficients[:, : 2 * LAGS], lagged)
        found = (
            found + coefficients[:, -2] * wanted[0] + coefficients[:, -1] * (wanted[0] - wanted[1])
        )
        found = found - self.anti_windup * (wanted[0] - command)
        return found, np.clip(found, self.low, self.high)

    def _error_of(self, runs: SampledRuns) -> float:
        """Error of the command in its own past, given the measurements."""
        coefficients = self.coefficients(runs.gains)
        lagged = features_of(runs.reference, runs.measured, self.delay)
        found = np.array(runs.command)
        wanted = found[:, :2].T.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(1, runs.time.size):
                one, found[:, k] = self.commands(coefficients, lagged[k], wanted, found[:, k - 1])
                wanted = np.stack([one, wanted[0]])
            size = np.sqrt(np.mean(runs.command**2, axis=1))
            error = np.sqrt(np.mean((found - runs.command) ** 2, axis=1))
        # A loop that swings between its limits follows no law for long: most runs do not.
        return float(np.median(np.nan_to_num(error, nan=np.inf) / np.maximum(size, 1e-300)))


def features_of(
    reference: NDArray[np.float64], measured: NDArray[np.float64], delay: int
) -> NDArray[np.float64]:
    """What each command was computed from, but for earlier commands, shape (n, L, 2 LAGS).

    Values, first and second differences of reference and measurement: neighbouring samples as they
    are would be nearly the same feature. Row k holds those of k - 1 - delay; before the first
    sample everything is at rest.

    Parameters
    ----------
    reference, measured : ndarray, shape (L, n)
        Of each run.
    delay : int
        Samples by which a command is late beside the one that it is held.
    """
    columns = []
    for values in (reference, measured):
        late = _later(values, 1 + delay)
        slope = late - _later(values, 2 + delay)
        columns += [late, slope, slope - (_later(values, 2 + delay) - _later(values, 3 + delay))]
    return np.stack(columns, axis=-1).transpose(1, 0, 2)


def _later(values: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    first = np.repeat(values[:, :1], samples, axis=1)
    return np.concatenate([first, values[:, :-samples]], axis=1)


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
    """Largest commands, where several samples after the first move have exactly the same."""
    moved = np.maximum.accumulate(runs.reference != runs.reference[:, :1], axis=1)
    ends, held = [], []
    for sign in (-1.0, 1.0):
        values = sign * runs.command
        ends.append(float(values.max()))
        near = moved & (values >= ends[-1] - (1.0 - _AT_LIMIT) * abs(ends[-1]))
        held.append(int(near.sum()) >= _HELD_ROWS)
    if any(held) and np.isclose(ends[0], ends[1], rtol=1e-6):
        held = [True, True]  # limits that are alike: the rarer one may be met for a sample only
    low, high = (end if is_held else np.inf for end, is_held in zip(ends, held, strict=True))
    return -low, high


def _weights(
    runs: SampledRuns,
    exponents: NDArray[np.int_],
    limits: tuple[float, float],
    delay: int,
    past: Past,
) -> tuple[NDArray[np.float64], float]:
    """Least squares over all rows in which nothing was limited, run by run compressed by QR.

    Returns
    -------
    weights : ndarray, shape (FEATURES, m)
    residual : float
        RMS error of one sample.
    """
    products, blocks, targets, rest, count = _products(runs.gains, exponents), [], [], 0.0, 0
    margin = (1.0 - _AT_LIMIT) * (float(np.sqrt(np.mean(runs.command**2))) or 1.0)
    free = (runs.command > limits[0] + margin) & (runs.command < limits[1] - margin)
    seen = features_of(runs.reference, runs.measured, delay)
    for row in range(len(runs)):
        u, open_ = runs.command[row], free[row]
        rows = np.flatnonzero(open_[2:] & open_[1:-1] & open_[:-2]) + 2
        if rows.size <= FEATURES:
            continue
        before, change = u[rows - 1], u[rows - 1] - u[rows - 2]
        own = {"none": [], "filter": [before], "integral": [change]}[past]
        left = u[rows] - before if past == "integral" else u[rows]
        columns = np.column_stack([seen[rows, row], *own, left])
        triangle = np.asarray(np.linalg.qr(columns, mode="r"), dtype=np.float64)
        blocks.append(np.kron(triangle[:-1, :-1], products[row]))
        targets.append(triangle[:-1, -1])
        rest, count = rest + float(triangle[-1, -1] ** 2), count + rows.size
    if not blocks:
        return np.zeros((FEATURES, len(exponents))), np.inf
    matrix, target = np.vstack(blocks), np.concatenate(targets)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    found, *_ = np.linalg.lstsq(matrix / scale, target, rcond=1e-10)
    rest += float(np.sum((matrix / scale @ found - target) ** 2))
    weights = np.zeros((FEATURES, len(exponents)))
    found = (found / scale).reshape(-1, len(exponents))
    weights[: 2 * LAGS] = found[: 2 * LAGS]
    if past == "filter":
        weights[-2] = found[-1]
    elif past == "integral":
        weights[-1] = found[-1]
        weights[-2, np.flatnonzero(exponents.sum(axis=1) == 0)] = 1.0
    return weights, float(np.sqrt(rest / count))
