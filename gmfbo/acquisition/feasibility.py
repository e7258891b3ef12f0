"""Weight an acquisition function by the probability that gains meet the limits on metrics.

Constrained expected improvement is EI times the probability of feasibility (Schonlau, Welch and
Jones 1998; Gardner et al. 2014, "Bayesian optimization with inequality constraints"). Here all
values are logarithms, so that the product is a sum for any acquisition function::

    weight = FeasibilityWeight([(model of overshoot, 5.0), ...])
    search = Search(dimension=2, log_weight=weight)      # used by maximise and recommend
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import torch
from botorch.acquisition.acquisition import AcquisitionFunction
from torch import Tensor

from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.surrogate.model import SourceModel
from gmfbo.surrogate.observations import IS1

_LEAST_VARIANCE = 1e-20

LogWeight = Callable[[Tensor], Tensor]


class FeasibilityWeight:
    """log of the product over the limits of Phi((most - mean) / sigma), of the real axis.

    Parameters
    ----------
    limited : sequence of (SourceModel, float)
        Posterior of each limited metric, and its largest allowed value [unit of the metric].
    """

    def __init__(self, limited: Sequence[tuple[SourceModel, float]]) -> None:
        self.limited = tuple(limited)

    def __call__(self, points: Tensor) -> Tensor:
        """Log probability, shape (m,), at points of the unit cube, shape (m, d)."""
        axis = torch.full_like(points[..., :1], IS1)
        inputs = torch.cat([points, axis], dim=-1)[..., None, :]
        total = torch.zeros(points.shape[:-1], dtype=points.dtype)
        for model, most in self.limited:
            with exact_algebra():
                posterior: Any = model.posterior(inputs)
                mean, variance = posterior.mean[..., 0, 0], posterior.variance[..., 0, 0]
            sigma = variance.clamp_min(_LEAST_VARIANCE).sqrt()
            total = total + torch.special.log_ndtr((most - mean) / sigma)
        return total


class WeightedAcquisition(AcquisitionFunction):
    """A log acquisition plus a log weight of the gains.

    Parameters
    ----------
    acquisition : AcquisitionFunction
        Over [gains, source], in logarithms.
    log_weight : callable
        From points, shape (m, d), to log weights, shape (m,).
    """

    def __init__(self, acquisition: AcquisitionFunction, log_weight: LogWeight) -> None:
        super().__init__(model=acquisition.model)
        self.acquisition, self.log_weight = acquisition, log_weight

    def forward(self, X: Tensor) -> Tensor:
        """Weighted acquisition, shape (b,), at inputs of shape (b, 1, d + 1)."""
        return self.acquisition(X) + self.log_weight(X[..., 0, :-1])
