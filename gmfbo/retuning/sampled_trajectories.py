"""Expected improvement from sampled trajectories of the axis: the cost's belief is not normal.

The objective is a known function of a trajectory, and the trajectory is what is uncertain. So
trajectories of the axis are drawn, the twin's plus a draw of the residual process, each is
scored, and the improvement is averaged over the draws (Astudillo and Frazier 2019, Bayesian
optimization of composite functions, equation 5). A response that may or may not leave the
settling band then has two costs, as it should, and not their mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.method import CorrectionOptions, Proposal
from gmfbo.tuning.methods.beliefs import corrected_and_twin
from gmfbo.tuning.methods.gmfbo import (
    CORRECTION,
    corrected_model,
    is_new,
    log_limit_weight,
    sample_times,
    twin_at_points,
)
from gmfbo.tuning.state import TuningState

if TYPE_CHECKING:
    from gmfbo.surrogate.corrected_twin import CorrectedTwinModel

DRAWS = 64
"""Sampled residuals, the same for all gains, so that gains are compared on equal luck."""


@dataclass(frozen=True)
class SampledTrajectories:
    """Expected improvement on the real axis over sampled trajectories."""

    name: str = "sampled_trajectories"
    summary: str = "expected improvement over sampled trajectories of the corrected twin"
    reference: str = "Astudillo and Frazier 2019, Bayesian optimization of composite functions"
    correction: CorrectionOptions = CORRECTION

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Ask the real axis where the draws improve most on the best real run."""
        from gmfbo.objective.mismatch import scaled_mismatch

        mismatch = scaled_mismatch(*corrected_and_twin(state, scaled=True))
        times = sample_times(state)
        points, simulated = twin_at_points(state, times)
        new = is_new(points, state)
        if not new.any():
            blind = state.hold(rng.random(len(state.space)))
            return Proposal("IS1", blind, mismatch, "the twin has not succeeded anywhere new")
        points, simulated = points[new], simulated[new]
        costs = sampled_costs(corrected_model(state, times), points, simulated, rng)
        improvement = np.maximum(state.incumbent() - costs, 0.0).mean(axis=0)
        weight = np.exp(log_limit_weight(state, times, points, simulated))
        # Where no draw improves, the least expected cost is what is left to go by.
        hope = improvement * weight
        if hope.max() <= 0.0:
            probable = weight >= min(0.5, float(weight.max()))
            hope = np.where(probable, -costs.mean(axis=0), -np.inf)
        return Proposal("IS1", points[int(np.argmax(hope))], mismatch)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least mean cost over the draws, among the gains where the twin was run."""
        times = sample_times(state)
        points, simulated = twin_at_points(state, times)
        if not len(points):
            best = min(state.of("IS1"), key=lambda seen: seen.objective)
            return best.point, best.objective, 0.0
        rng = np.random.default_rng(0)
        costs = sampled_costs(corrected_model(state, times), points, simulated, rng)
        row = int(np.argmin(costs.mean(axis=0)))
        return points[row], float(costs[:, row].mean()), float(costs[:, row].std())


def sampled_costs(
    model: CorrectedTwinModel,
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Costs of sampled trajectories of the axis, shape (DRAWS, q).

    Parameters
    ----------
    model : CorrectedTwinModel
        Holds the residual process.
    points : ndarray, shape (q, d)
        In the unit cube.
    simulated : ndarray, shape (q, m)
        [signal] The twin there.
    rng : numpy.random.Generator
        Of the draws.
    """
    expected = model.trajectory(points, simulated)
    share = model.residual.share(points)
    return np.stack(
        [
            model.cost_of(expected + share[:, None] * draw)
            for draw in model.residual.deviations(DRAWS, rng)
        ]
    )
