"""Knowledge gradient over gains and source: how much a run lowers the least expected cost.

KG(k, s) = (min mu(., 1) - E[min mu'(., 1) after a run at (k, s)]) / cost(s),
cost(s) = 0.1 + 0.9 s

(Wu, Toscano-Palmerin, Frazier and Wilson 2019, taKG; with two sources there is no trace of cheaper
fidelities). The minimum is taken over points that cover the box, where a run moves the posterior
mean along a line,

mu'(., 1) = mu(., 1) + Z c((k, s), (., 1)) / sqrt(c((k, s), (k, s)) + noise),  Z ~ N(0, 1)

(Frazier, Powell and Dayanik 2009, eq. 12), and the expectation over quantiles of Z. BoTorch's
one-shot form optimises outcomes and minima together. It takes eight times as long and ends at 0.8
of the value in the median, at worst at 0.04 (`tests/benchmarks/knowledge_gradient.py`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from botorch.acquisition.acquisition import AcquisitionFunction
from botorch.utils.transforms import t_batch_mode_transform
from numpy.typing import NDArray
from torch import Tensor

from gmfbo.acquisition.maximise import Search, recommend
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.surrogate.observations import with_source
from gmfbo.surrogate.truncated import TruncatedModel

FIXED_COST, SOURCE_COST = 0.1, 0.9
"""Cost of a twin run, and extra cost of a real run [real runs]."""

QUANTILES = 64
"""Number of outcomes of a run in the expectation."""

_OUTCOMES = torch.special.ndtri((torch.arange(QUANTILES, dtype=DTYPE) + 0.5) / QUANTILES)
"""Equally probable quantiles of a standard normal variable, ascending."""

_LEAST = 1e-30  # replaces zero in a logarithm
_TOGETHER = 8  # runs evaluated in one block, which then fits in a cache


class KnowledgeGradient(AcquisitionFunction):
    """log KG at [gains, source], to be maximised; g is minimised.

    Parameters
    ----------
    model : TruncatedModel
        Posterior of g.
    search : Search
        The minimum is taken over its pool, the runs so far and the point of least posterior
        mean; with limits, over those of them that probably meet the limits.
    """

    def __init__(self, model: TruncatedModel, search: Search) -> None:
        super().__init__(model=model)
        least, _ = recommend(model, search)
        inputs, likelihood = model.train_inputs[0], model.likelihood
        transform: Any = model.outcome_transform
        with exact_algebra(), torch.no_grad():
            covariance: Any = likelihood(model.forward(inputs), inputs).covariance_matrix
            self._inputs, self._root = inputs, torch.linalg.cholesky(covariance)
            self._noise = likelihood.noise.flatten()[0]
            self._scale = transform.stdvs.flatten()[0]
            ran: NDArray[Any] = inputs[:, :-1].numpy()
            ends = with_source(np.vstack([least, search.pool(), ran]), "IS1")
            weights = torch.as_tensor(search.log_weights(ends[:, :-1].numpy()))
            ends = ends[weights >= min(math.log(0.5), float(weights.max()))]
            posterior: Any = model.posterior(ends)
            mean = posterior.mean[:, 0] / self._scale
            spread = posterior.variance[:, 0].sqrt() / self._scale
            # A point that is the minimum for no outcome can be left out.
            most = _OUTCOMES[-1] * spread
            possible = mean - most <= (mean + most).min()
            self._ends, self._mean = ends[possible], mean[possible]
            self._ends_told = self._told(self._ends)

    def _told(self, inputs: Tensor) -> Tensor:
        """L^-1 c(runs, inputs), shape (n, q)."""
        model: Any = self.model
        across = model.covar_module(self._inputs, inputs).to_dense()
        told: Tensor = torch.linalg.solve_triangular(self._root, across, upper=False)
        return told

    @t_batch_mode_transform(expected_q=1)  # type: ignore[arg-type]
    def forward(self, X: Tensor) -> Tensor:
        """Log of the knowledge gradient, shape (b,), at inputs of shape (b, 1, d + 1)."""
        with exact_algebra():
            inputs = X[..., 0, :]
            gains = torch.cat([self._gain(some) for some in self._slopes(inputs).split(_TOGETHER)])
            cost = FIXED_COST + SOURCE_COST * inputs[..., -1]
            return (self._scale * gains / cost).clamp_min(_LEAST).log()

    def _slopes(self, inputs: Tensor) -> Tensor:
        """Change of the mean at the ends for one outcome Z = 1 of each run, shape (b, q)."""
        model: Any = self.model
        told = self._told(inputs)
        across = model.covar_module(inputs, self._ends).to_dense() - told.T @ self._ends_told
        own = model.covar_module(inputs, diag=True) - told.square().sum(dim=0)
        slopes: Tensor = across / (own.clamp_min(0.0) + self._noise).sqrt()[:, None]
        return slopes

    def _gain(self, slopes: Tensor) -> Tensor:
        """Fall of the least expected cost by each run, shape (b,) [standardised g]."""
        moved = self._mean + slopes[:, None, :] * _OUTCOMES[:, None]
        return self._mean.min() - moved.amin(dim=-1).mean(dim=-1)
