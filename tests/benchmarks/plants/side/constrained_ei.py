"""Expected improvement where the envelope is probably kept."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import seek_finished
from gmfbo.tuning.query.method import Proposal
from tests.benchmarks.plants.side.priced_runs import (
    Vector,
    expected_costs,
    least_expected_run,
    priced,
    stock_process,
)


@dataclass(frozen=True, eq=False)
class ConstrainedEi:
    """BoTorch's constrained expected improvement, on the cost and on how far a run left its range.

    Attributes
    ----------
    ranges : mapping of str to (float, float)
        Envelope of each limited signal [unit of the signal].
    """

    ranges: dict[str, tuple[float, float]]
    name: str = "constrained_ei"
    summary: str = "expected improvement times the probability that the envelope is kept"
    reference: str = "Gardner et al. 2014, Bayesian optimization with inequality constraints"
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise its logarithm over the unit cube by `optimize_acqf` with its usual settings."""
        import torch
        from botorch.acquisition.analytic import LogConstrainedExpectedImprovement
        from botorch.models.model_list_gp_regression import ModelListGP
        from botorch.optim.optimize import optimize_acqf

        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        torch.manual_seed(int(rng.integers(2**31)))
        cost, beyond = self._models(state)
        best = min(one.objective for one in state.of("IS1") if one.counts)
        acquisition = LogConstrainedExpectedImprovement(
            ModelListGP(cost, beyond), best_f=-best, objective_index=0, constraints={1: (0.0, None)}
        )
        bounds = torch.stack([torch.zeros(len(state.space)), torch.ones(len(state.space))]).double()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found, _ = optimize_acqf(acquisition, bounds, q=1, num_restarts=10, raw_samples=512)
        point = found.detach().numpy()[0]
        mean, std = expected_costs(cost, point[None, :])
        return Proposal("IS1", point, expected=(float(mean[0]), float(std[0])))

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """Least posterior mean among the runs that settled."""
        return least_expected_run(self._models(state)[0], state)

    def _models(self, state: TuningState) -> tuple[Any, Any]:
        """Gaussian processes of the cost, and of how far runs left the envelope.

        Runs that left it have no cost, since the axis was stopped; other runs that failed or did
        not settle have their price.
        """
        points, costs = priced(state)
        runs = [trial for trial in state.trials if trial.source == "IS1"]
        kept = np.array([trial.status != "unsafe" for trial in runs])
        beyond = np.array([self.beyond(trial) for trial in runs])
        known = np.isfinite(beyond)
        return stock_process(points[kept], costs[kept]), stock_process(points[known], beyond[known])

    def beyond(self, trial: Trial) -> float:
        """By how many widths of the envelope a run left it, negative inside; NaN if unknown."""
        recording, most = trial.recording, -np.inf
        for name, (low, high) in self.ranges.items():
            values = recording.signal(name)
            values = values[np.isfinite(values)]
            if not values.size:
                return float("nan")
            width = high - low
            most = max(
                most, float((values.max() - high) / width), float((low - values.min()) / width)
            )
        return most
