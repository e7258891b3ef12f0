"""Expected improvement of a cost that is a known function of a trajectory.

The belief is about trajectories; each draw passes through the metrics, so that the belief about
the cost keeps their jumps (composite Bayesian optimisation, Astudillo and Frazier 2019).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gmfbo.correction.residual_process import ResidualProcess

CostOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""From trajectories, shape (q, m), to costs g, shape (q,), to be minimised."""


def real_cost_draws(
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
    residual: ResidualProcess,
    cost_of: CostOf,
    deviations: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Draws of the real cost where the twin was run.

    Parameters
    ----------
    points : ndarray, shape (q, d)
        Gains in the unit cube.
    simulated : ndarray, shape (q, m)
        Trajectory of the twin there [unit of the signal].
    residual : ResidualProcess
        Fitted to real minus simulated trajectories.
    cost_of : callable
        From trajectories to costs.
    deviations : ndarray, shape (count, m)
        From `ResidualProcess.deviations`; the same for all points, so that neighbours compare.

    Returns
    -------
    ndarray, shape (count, q)
        One row a draw.
    """
    corrected = simulated + residual.mean(points)
    share = residual.share(points)[:, None]
    return np.stack([cost_of(corrected + share * deviation) for deviation in deviations])


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
