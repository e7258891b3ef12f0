"""Expected improvement of a cost that is a known function of a trajectory.

The belief is about trajectories; each draw passes through the metrics, so that the belief about
the cost keeps their jumps (composite Bayesian optimisation, Astudillo and Frazier 2019, eq. 2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.residual_process import ResidualProcess

CostOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class TrajectoryBelief:
    """Real trajectory at any gains: emulated twin plus residual.

    Attributes
    ----------
    twin : ResidualProcess
        Fitted to trajectories of the twin.
    residual : ResidualProcess
        Fitted to real minus twin trajectories.
    cost_of : callable
        From trajectories, shape (..., m), to costs g, shape (...), to be minimised.
    """

    twin: ResidualProcess
    residual: ResidualProcess
    cost_of: CostOf

    def mean_trajectory(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Expected real trajectory, shape (q, m), at points of the unit cube, shape (q, d)."""
        return self.twin.mean(points) + self.residual.mean(points)

    def cost_draws(
        self, points: NDArray[np.float64], count: int, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Draws of the real cost, shape (count, q), at points of the unit cube, shape (q, d)."""
        centre = self.mean_trajectory(points)
        parts = [
            (process.share(points)[:, None], process.deviations(count, rng))
            for process in (self.residual, self.twin)
        ]
        return np.stack(
            [
                self.cost_of(centre + sum(share * draws[row] for share, draws in parts))
                for row in range(count)
            ]
        )


def expected_improvement(cost_draws: NDArray[np.float64], incumbent: float) -> NDArray[np.float64]:
    """Mean of max(incumbent - g, 0) over draws, shape (q,); g is minimised.

    Parameters
    ----------
    cost_draws : ndarray, shape (count, q)
        Draws of the cost.
    incumbent : float
        Least cost observed.
    """
    return np.asarray(np.maximum(incumbent - cost_draws, 0.0).mean(axis=0))
