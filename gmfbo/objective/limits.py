"""Limits on metrics, and the probability that gains meet them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import log_ndtr

from gmfbo.errors import InputError
from gmfbo.objective.margins import AT_LEAST, MARGINS

_LEAST_SIGMA = 1e-10


@dataclass(frozen=True)
class Limits:
    """Limits on metrics, for each reference.

    Attributes
    ----------
    stated : mapping of str to float
        Limit by metric [unit of the metric]; the least value of phase and gain margin, the
        largest of all others. Empty where nothing is limited.
    """

    stated: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, value in self.stated.items():
            if not np.isfinite(value):
                raise InputError(f"constraints: expected a number for '{name}', got {value}")
        object.__setattr__(self, "stated", MappingProxyType(dict(self.stated)))

    def __bool__(self) -> bool:
        return bool(self.stated)

    @property
    def most(self) -> Mapping[str, float]:
        """Largest value that `limited` may have, by limited metric."""
        return {name: _sign(name) * value for name, value in self.stated.items()}

    @property
    def of_the_twin(self) -> bool:
        """Whether a margin is limited, which the twin is asked for."""
        return any(name in MARGINS for name in self.stated)

    def limited(self, metrics: Mapping[str, ArrayLike]) -> dict[str, NDArray[np.float64]]:
        """Value of each limited metric to be compared with its limit.

        Parameters
        ----------
        metrics : mapping of str to array_like, shape (...)
            Of one run or many. With several references, `overshoot` is their mean, which may hide
            a bad one, and `overshoot[2]` belongs to the second: the largest of these counts.

        Returns
        -------
        dict of str to ndarray, shape (...)
            By limited metric [unit of the metric]; margins that have a least value with a minus,
            NaN where the metric was not measured.
        """
        found = {}
        for name in self.stated:
            each = [np.asarray(value, float) for key, value in metrics.items() if _is_of(key, name)]
            found[name] = _sign(name) * np.max(each, axis=0) if each else np.asarray(np.nan)
        return found

    def excess(self, metrics: Mapping[str, float]) -> float:
        """Sum of relative excesses over the limits; zero where all limits are met.

        A metric that was not measured meets no limit: its excess is infinite.
        """
        limited = {name: float(value) for name, value in self.limited(metrics).items()}
        if any(np.isnan(value) for value in limited.values()):
            return float(np.inf)
        return sum(
            max(value - self.most[name], 0.0) / (abs(self.most[name]) or 1.0)
            for name, value in limited.items()
        )

    def met(self, metrics: Mapping[str, float]) -> bool:
        """Whether a run meets all limits."""
        return self.excess(metrics) == 0.0


def log_feasibility(mean: ArrayLike, variance: ArrayLike, most: float) -> NDArray[np.float64]:
    """Logarithm of the probability that a normal metric is at most its limit.

    log Phi((most - mean) / sigma): Schonlau, Welch and Jones (1998), "Global versus local search
    in constrained optimization of computer models".

    Parameters
    ----------
    mean, variance : array_like, shape (q,)
        Posterior of the metric [unit of the metric, and its square].
    most : float
        Limit [unit of the metric].

    Returns
    -------
    ndarray, shape (q,)
        Zero or less; finite also far beyond the limit.
    """
    sigma = np.maximum(np.sqrt(np.asarray(variance, dtype=float)), _LEAST_SIGMA)
    # Beyond 1e100 standard deviations the square in log Phi would overflow.
    distance = np.clip((most - np.asarray(mean, dtype=float)) / sigma, -1e100, 1e100)
    return np.asarray(log_ndtr(distance))


def _sign(name: str) -> float:
    return -1.0 if name in AT_LEAST else 1.0


def _is_of(key: str, name: str) -> bool:
    return key == name or key.startswith(f"{name}[")
