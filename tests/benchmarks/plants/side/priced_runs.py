"""Real runs as rivals see them: those that failed or did not settle have a price."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState

Vector = NDArray[np.float64]


def priced(state: TuningState) -> tuple[Vector, Vector]:
    """Points (n, d) in the unit cube and costs (n,) of all real runs, one of which has settled.

    A run that failed or did not settle costs as much as the worst settled one, and their range
    or at least 1 on top.
    """
    real = state.of("IS1")
    known = np.array([one.objective for one in real if one.counts])
    price = float(known.max()) + max(float(np.ptp(known)), 1.0)
    costs = [one.objective if one.counts else price for one in real]
    return np.stack([one.point for one in real]), np.array(costs)


def stock_process(points: Vector, costs: Vector) -> Any:
    """BoTorch's `SingleTaskGP` with its defaults, of costs with the sign turned.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        In the unit cube.
    costs : ndarray, shape (n,)
        To be minimised.
    """
    import torch
    from botorch.fit import fit_gpytorch_mll
    from botorch.models import SingleTaskGP
    from gpytorch.mlls import ExactMarginalLogLikelihood

    model = SingleTaskGP(
        torch.tensor(points, dtype=torch.float64),
        -torch.tensor(costs, dtype=torch.float64)[:, None],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit_gpytorch_mll(ExactMarginalLogLikelihood(model.likelihood, model))
    return model


def expected_costs(model: Any, points: Vector) -> tuple[Vector, Vector]:
    """Posterior mean and standard deviation of the cost at points (q, d), each (q,)."""
    import torch

    with torch.no_grad():
        posterior = model.posterior(torch.tensor(points, dtype=torch.float64))
    return -posterior.mean.numpy()[:, 0], np.sqrt(posterior.variance.numpy()[:, 0])


def least_expected_run(model: Any, state: TuningState) -> tuple[Vector, float, float]:
    """Least posterior mean among the runs that settled: point (d,), mean, standard deviation."""
    points = np.stack([one.point for one in state.of("IS1") if one.counts])
    mean, std = expected_costs(model, points)
    best = int(np.argmin(mean))
    return points[best], float(mean[best]), float(std[best])


def least_measured_run(state: TuningState) -> tuple[Vector, float, float]:
    """Least cost that was measured among the runs that settled: point (d,), cost, 0."""
    best = min((one for one in state.of("IS1") if one.counts), key=lambda one: one.objective)
    return best.point, best.objective, 0.0
