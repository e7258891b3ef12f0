"""Objective: weighted, normalised cost of a run, to be minimised."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.errors import InputError, did_you_mean
from gmfbo.objective.metrics import METRICS, worst_metrics

PAPER_WEIGHTS: Mapping[str, float] = MappingProxyType(
    {"overshoot": 0.02, "transient_time": 0.20, "rise_time": 0.70, "settling_time": 0.20}
)
"""Weights of the paper's numerical study; they sum to 1.12 there and here."""

MetricArrays = Mapping[str, ArrayLike]

# A metric that is equal in all samples (overshoot of sluggish gains) would be divided by zero; one
# percent of the worst case is one percent of overshoot, or of the horizon.
_LEAST_STD = 0.01


@dataclass(frozen=True)
class Objective:
    """Cost g = sum_i w_i (h_i - mean_i) / std_i over the metrics h_i, to be minimised.

    Each metric counts up to its worst case, so that no run costs more than a failed one.

    Attributes
    ----------
    weights : mapping of str to float
        w_i by metric, dimensionless.
    mean, std : mapping of str to float
        Normalising constants [unit of the metric].
    worst : mapping of str to float
        All metrics, with their values for a failed run [unit of the metric].
    """

    weights: Mapping[str, float]
    mean: Mapping[str, float]
    std: Mapping[str, float]
    worst: Mapping[str, float]

    def __post_init__(self) -> None:
        if not self.weights:
            raise InputError(f"weights: expected at least one of {', '.join(METRICS)}, got none")
        for name, weight in self.weights.items():
            if name not in self.worst:
                raise InputError(f"weights: no metric '{name}'" + did_you_mean(name, self.worst))
            if not (np.isfinite(weight) and weight >= 0.0):
                raise InputError(f"weights: '{name}' must be zero or more, got {weight}")
            if not self.std[name] > 0.0:
                raise InputError(f"std of '{name}' must be positive, got {self.std[name]}")
        for field in ("weights", "mean", "std", "worst"):
            object.__setattr__(self, field, MappingProxyType(dict(getattr(self, field))))

    @classmethod
    def from_samples(
        cls,
        weights: Mapping[str, float],
        metrics_samples: MetricArrays,
        *,
        horizon: float | None = None,
        worst: Mapping[str, float] | None = None,
    ) -> Self:
        """Take mean and standard deviation from runs that succeeded.

        Parameters
        ----------
        weights : mapping of str to float
            w_i by metric, a user's own included.
        metrics_samples : mapping of str to array_like, shape (m,)
            Metrics of the runs [% or s], and a user's own. With m < 2 the worst case is the
            scale, mean zero.
        horizon : float, optional
            [s] Length after the step; sets the cost of a failed run.
        worst : mapping of str to float, optional
            Step metrics of a failed run, in place of `horizon`. The worst case of a user's own
            metric lies above the largest sample by the range of the samples.

        Returns
        -------
        Objective
            With each standard deviation at least one percent of the worst case.
        """
        samples = {name: np.asarray(values, float) for name, values in metrics_samples.items()}
        own = {name: _own_worst(samples[name]) for name in samples if name not in METRICS}
        if worst is None:
            if horizon is None:
                raise InputError("expected the horizon of the step, or the worst metrics")
            worst = worst_metrics(horizon)
        worst = {**worst, **own}
        mean, std = {}, {}
        for name in worst:
            sample = samples[name]
            mean[name] = float(sample.mean()) if sample.size > 1 else 0.0
            spread = float(sample.std(ddof=1)) if sample.size > 1 else worst[name]
            std[name] = max(spread, _LEAST_STD * abs(worst[name])) or 1.0
        return cls(weights=weights, mean=mean, std=std, worst=worst)

    def value(self, metrics: MetricArrays) -> NDArray[np.float64]:
        """Cost g of runs, dimensionless, may be negative.

        Parameters
        ----------
        metrics : mapping of str to array_like, shape (...)
            Each weighted metric [% or s]; NaN, for an unknown value, counts as the mean.

        Returns
        -------
        ndarray, shape (...)
            To be minimised.
        """
        return self.scaled(metrics) - self._offset

    def scaled(self, metrics: MetricArrays) -> NDArray[np.float64]:
        """Scaled cost G = sum_i w_i h_i / std_i: g without the mean subtracted, never negative.

        Ratios of G have a meaning, ratios of g do not: g crosses zero.

        Parameters
        ----------
        metrics : mapping of str to array_like, shape (...)
            Each weighted metric [% or s].

        Returns
        -------
        ndarray, shape (...)
            Zero or more.
        """
        terms = [
            weight * self._counted(name, metrics[name]) / self.std[name]
            for name, weight in self.weights.items()
        ]
        return np.asarray(np.sum(np.broadcast_arrays(*terms), axis=0))

    def contribution(self, name: str, value: float) -> float:
        """What one metric adds to the cost g of a run: w (h - mean) / std.

        Parameters
        ----------
        name : str
            A weighted metric.
        value : float
            h [unit of the metric].
        """
        counted = float(self._counted(name, value))
        return self.weights[name] * (counted - self.mean[name]) / self.std[name]

    def _counted(self, name: str, values: ArrayLike) -> NDArray[np.float64]:
        """A metric limited to its worst case, or its mean where it is unknown."""
        known = np.asarray(values, dtype=float)
        return np.minimum(np.where(np.isnan(known), self.mean[name], known), self.worst[name])

    @property
    def failed(self) -> float:
        """Cost of a failed run, with 100 % overshoot and no settling."""
        return float(self.value(self.worst))

    @property
    def _offset(self) -> float:
        return sum(w * self.mean[name] / self.std[name] for name, w in self.weights.items())


def _own_worst(sample: NDArray[np.float64]) -> float:
    """Value of a user's own metric for a failed run, from the samples."""
    return float(sample.max() + (np.ptp(sample) or abs(sample.max()) or 1.0))
