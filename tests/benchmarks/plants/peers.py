"""Rivals that are not gmfbo's: stock BoTorch, and the gains of a textbook."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import seek_finished
from gmfbo.tuning.methods.identify_then_optimise import READING
from gmfbo.tuning.query.method import CorrectionOptions, Proposal
from tests.benchmarks.plants.side.priced_runs import (
    expected_costs,
    least_expected_run,
    priced,
    stock_process,
)

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class StockLogEi:
    """BoTorch as its tutorial has it: SingleTaskGP and LogExpectedImprovement on real runs.

    Runs that failed or did not settle are `priced`, once one has settled; before, the study looks
    for a run that settles, as every method here.
    """

    name: str = "log_ei"
    summary: str = "BoTorch's SingleTaskGP and LogExpectedImprovement with their defaults"
    reference: str = "Ament et al. 2023, Unexpected improvements to expected improvement"
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Maximise LogEI over the unit cube by `optimize_acqf` with its usual settings."""
        import torch
        from botorch.acquisition.analytic import LogExpectedImprovement
        from botorch.optim.optimize import optimize_acqf

        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        torch.manual_seed(int(rng.integers(2**31)))
        points, costs = priced(state)
        model = stock_process(points, costs)
        acquisition = LogExpectedImprovement(model, best_f=-float(costs.min()))
        bounds = torch.stack([torch.zeros(len(state.space)), torch.ones(len(state.space))]).double()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found, _ = optimize_acqf(acquisition, bounds, q=1, num_restarts=10, raw_samples=512)
        point = found.detach().numpy()[0]
        mean, std = expected_costs(model, point[None, :])
        return Proposal("IS1", point, expected=(float(mean[0]), float(std[0])))

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """Least posterior mean among the runs that settled."""
        return least_expected_run(stock_process(*priced(state)), state)


SAME = 1e-3
"""Distance in the unit cube within which the gains of the rule count as run."""


@dataclass(frozen=True)
class TextbookRule:
    """Gains by a rule from a model of the first runs, approached as the moves allow; then it ends.

    Attributes
    ----------
    plant : str
        Name in the catalogue; it says which rule.
    initial : int
        Runs that the model is identified from.
    """

    plant: str
    initial: int = 2
    name: str = "textbook_rule"
    summary: str = "SIMC gains from a model of the first runs"
    reference: str = "Skogestad 2003, Simple analytic rules; see rules.py"
    correction: CorrectionOptions = READING

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """Ask the axis at the gains of the rule, unless it ran there."""
        point = state.hold(self._gains(state))
        if any(np.abs(one.point - point).max() < SAME for one in state.of("IS1")):
            return None
        return Proposal("IS1", point)

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """The gains of the rule, run or not."""
        return self._gains(state), 0.0, 0.0

    def _gains(self, state: TuningState) -> Vector:
        from tests.benchmarks.plants.rules import rule_gains

        real = [trial for trial in state.trials if trial.source == "IS1"][: self.initial]
        return rule_gains(self.plant, [t.recording for t in real if t.status == "ok"], state)
