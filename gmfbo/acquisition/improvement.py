r"""Expected improvement of the objective g, which is minimised, per source and per query cost.

improvement = max(g+ - g, 0) with the incumbent g+; for a normal posterior (mean mu, standard
deviation sigma) and u = (g+ - mu) / sigma:

EI = sigma (phi(u) + u Phi(u)),   caEI(k, s) = EI(k, s) / H(s)    (H: query cost, H(IS1) = 1)

Values are compared as log EI - log H, which does not underflow where EI is tiny.

`CostAwareExpectedImprovement` is a BoTorch acquisition function over [gains, source]; it holds
one incumbent for each source. With `value="axis"`, a query of another source is worth its
information about the axis at these gains: EI of the axis times the posterior correlation of the two
(the fidelity factor of augmented EI, Huang et al. 2006). As published, it is worth the improvement
of the twin over the twin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import torch
from botorch.acquisition.analytic import AnalyticAcquisitionFunction
from botorch.models.model import Model
from botorch.utils.transforms import t_batch_mode_transform
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import IS1, source_column

Value = Literal["source", "axis"]

_LOG_SQRT_2PI = 0.5 * math.log(2.0 * math.pi)
_LEAST_SIGMA = 1e-10


def log_expected_improvement(mean: Tensor, sigma: Tensor, incumbent: Tensor | float) -> Tensor:
    """Logarithm of EI, finite wherever u^2 is; differentiable.

    Ament et al. (2023), "Unexpected improvements to expected improvement", equation 9.
    """
    sigma = sigma.clamp_min(_LEAST_SIGMA)
    return torch.log(sigma) + _log_h((incumbent - mean) / sigma)


def log_improvement(mean: ArrayLike, variance: ArrayLike, incumbent: float) -> NDArray[np.float64]:
    """`log_expected_improvement` for arrays: mean [g] and variance [g^2], shape (q,)."""
    sigma = torch.tensor(np.sqrt(np.asarray(variance, dtype=float)), dtype=DTYPE)
    means = torch.tensor(np.asarray(mean, dtype=float), dtype=DTYPE)
    return np.asarray(log_expected_improvement(means, sigma, incumbent).numpy())


def _log_h(u: Tensor) -> Tensor:
    """log(phi(u) + u Phi(u)), in three branches, each given only arguments of its range."""
    near = u.clamp_min(-1.0)
    direct = torch.log(
        torch.exp(-0.5 * near.square() - _LOG_SQRT_2PI) + near * torch.special.ndtr(near)
    )
    # For u < -1 the sum cancels: log phi(u) + log(1 - |u| sqrt(pi/2) erfcx(|u| / sqrt(2))).
    middle = u.clamp(-1e3, -1.0).neg()
    scaled = torch.special.erfcx(middle / math.sqrt(2.0))
    tail = torch.log1p(-middle * math.sqrt(math.pi / 2.0) * scaled)
    # For very negative u, that bracket is 1/u^2 - 3/u^4 + ...
    far = u.clamp_max(-1e3).neg()
    limit = -2.0 * torch.log(far) + torch.log1p(-3.0 / far.square())
    correction = torch.where(u < -1e3, limit, tail)
    return torch.where(u > -1.0, direct, -0.5 * u.square() - _LOG_SQRT_2PI + correction)


class CostAwareExpectedImprovement(AnalyticAcquisitionFunction):
    """log EI - log H at [gains, source], to be maximised; g is minimised.

    Parameters
    ----------
    model : Model
        Posterior of g; last input column is the source (1 axis, 0 twin).
    incumbents : mapping of str to float
        Least g by source name, for each source that is evaluated.
    costs : mapping of str to float
        H by source name, 1 for the axis.
    value : {"source", "axis"}
        Worth of a query of another source than the axis: its own improvement (as published),
        or the improvement of the axis times their correlation.

    Raises
    ------
    InputError
        A cost is not positive, or a source has a cost but no incumbent.
    """

    def __init__(
        self,
        model: Model,
        incumbents: Mapping[str, float],
        costs: Mapping[str, float],
        value: Value = "source",
    ) -> None:
        super().__init__(model=model)
        self.incumbents = {source_column(name): best for name, best in incumbents.items()}
        self.log_costs = {}
        for name, cost in costs.items():
            if not cost > 0.0:
                raise InputError(f"expected a positive query cost for {name}, got {cost}")
            needed = "IS1" if value == "axis" else name
            if needed not in incumbents:
                raise InputError(f"no incumbent for {needed}; give its least objective")
            self.log_costs[source_column(name)] = math.log(cost)
        self.value = value

    @t_batch_mode_transform(expected_q=1)  # type: ignore[arg-type]
    def forward(self, X: Tensor) -> Tensor:
        """Acquisition, shape (b,), at inputs of shape (b, 1, d + 1)."""
        with exact_algebra():
            columns = X[..., 0, -1].detach()
            result = torch.zeros(X.shape[:-2], dtype=X.dtype)
            for column in columns.unique().tolist():
                if column not in self.log_costs:
                    raise InputError(f"no query cost for source column {column:g}")
                here = columns == column
                result = result.masked_scatter(here, self._of_source(X[here], column))
            return result

    def _of_source(self, X: Tensor, column: float) -> Tensor:
        if self.value == "source" or column == IS1:
            posterior: Any = self.model.posterior(X)
            mean, variance = posterior.mean[..., 0, 0], posterior.variance[..., 0, 0]
            best, log_fidelity = self.incumbents[column], 0.0
        else:
            # Axis and source at the same gains, jointly: shape (b, 2, d + 1).
            axis = torch.cat([X[..., :-1], torch.full_like(X[..., -1:], IS1)], dim=-1)
            posterior = self.model.posterior(torch.cat([axis, X], dim=-2))
            covariance = posterior.distribution.covariance_matrix
            mean, variance = posterior.mean[..., 0, 0], covariance[..., 0, 0]
            product = variance * covariance[..., 1, 1]
            squared = covariance[..., 0, 1].square() / product.clamp_min(_LEAST_SIGMA**4)
            log_fidelity = 0.5 * squared.clamp_min(_LEAST_SIGMA).log()
            best = self.incumbents[IS1]
        sigma = variance.clamp_min(_LEAST_SIGMA**2).sqrt()
        return log_expected_improvement(mean, sigma, best) + log_fidelity - self.log_costs[column]
