"""A trust region about the best run, as TuRBO-1 has it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import seek_finished
from gmfbo.tuning.query.method import Proposal
from tests.benchmarks.plants.side.priced_runs import (
    Vector,
    least_expected_run,
    priced,
    stock_process,
)

FIRST, LEAST, MOST = 0.8, 0.5**7, 1.6
"""Edge of the trust region in the unit cube: at first, the shortest and the longest."""

SUCCESSES = 3
"""Improvements in a row after which the region doubles."""

CANDIDATES = 11
"""Binary logarithm of how many points are drawn from: the publication's 2,000 and a few."""

IMPROVES = 1e-3
"""Share of the best cost by which a run must be better to count as an improvement."""


@dataclass(frozen=True)
class Turbo:
    """TuRBO with one region and one run at a time: Thompson sampling within it.

    The region halves after as many runs without an improvement as there are gains, at least four.

    Attributes
    ----------
    initial : int
        Real runs before it proposes.
    """

    initial: int = 2
    name: str = "turbo"
    summary: str = "Thompson sampling in a trust region about the best run"
    reference: str = "Eriksson et al. 2019, Scalable global optimization via local Bayesian optim."
    correction: None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Minimum of a draw of the Gaussian process over the trust region."""
        import torch
        from botorch.generation.sampling import MaxPosteriorSampling

        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        points, costs = priced(state)
        model = stock_process(points, costs)
        scales = model.covar_module.lengthscale.detach().numpy().reshape(-1)
        edges = edge(costs, points.shape[1], self.initial) * relative(scales)
        centre = points[int(np.argmin(costs))]
        low = np.clip(centre - edges / 2.0, 0.0, 1.0)
        high = np.clip(centre + edges / 2.0, 0.0, 1.0)
        seed = int(rng.integers(2**31))
        torch.manual_seed(seed)
        tried = candidates(centre, low, high, seed)
        with torch.no_grad():
            sampling = MaxPosteriorSampling(model, replacement=False)
            found = sampling(torch.tensor(tried), num_samples=1)
        return Proposal("IS1", state.hold(found.numpy()[0]))

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """Least posterior mean among the runs that settled."""
        return least_expected_run(stock_process(*priced(state)), state)


def edge(costs: Vector, width: int, initial: int) -> float:
    """Edge of the trust region after runs of these costs (n,), of `width` gains.

    A region that has become too short begins anew at its first edge.
    """
    length, better, worse = FIRST, 0, 0
    for row in range(initial, len(costs)):
        best = float(costs[:row].min())
        if costs[row] < best - IMPROVES * abs(best):
            better, worse = better + 1, 0
        else:
            better, worse = 0, worse + 1
        if better == SUCCESSES:
            length, better = min(2.0 * length, MOST), 0
        elif worse == max(4, width):
            length, worse = length / 2.0, 0
        if length < LEAST:
            length, better, worse = FIRST, 0, 0
    return length


def relative(scales: Vector) -> Vector:
    """Lengthscales (d,) over their geometric mean: the region is longer where the cost is flat."""
    return np.asarray(scales / math.exp(float(np.log(scales).mean())))


def candidates(centre: Vector, low: Vector, high: Vector, seed: int) -> Vector:
    """Points (q, d) of the region: the centre, with some of its gains drawn anew."""
    width, count = len(centre), 2**CANDIDATES
    drawn = qmc.Sobol(d=width, rng=seed).random_base2(CANDIDATES)
    rng = np.random.default_rng(seed)
    changed = rng.random((count, width)) <= min(20.0 / width, 1.0)
    none = ~changed.any(axis=1)
    changed[none, rng.integers(width, size=int(none.sum()))] = True
    return np.asarray(np.where(changed, low + (high - low) * drawn, centre))
