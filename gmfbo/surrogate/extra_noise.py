"""Extra noise of single observations, to give them less weight."""

from __future__ import annotations

from typing import Any

import torch
from botorch.models.gpytorch import GPyTorchModel
from gpytorch.likelihoods.noise_models import Noise
from linear_operator.operators import DiagLinearOperator, LinearOperator
from torch import Tensor

from gmfbo.surrogate.observations import Observations


class ExtraNoise(Noise):
    """A noise model, with extra variances of the fitted rows.

    Parameters
    ----------
    inner : Noise
        Of all rows.
    inputs : Tensor, shape (n, d + 1)
        Rows that are fitted.
    extra : Tensor, shape (n,)
        Variance [standardised objective squared].
    """

    def __init__(self, inner: Noise, inputs: Tensor, extra: Tensor) -> None:
        super().__init__()
        self.inner = inner
        self.register_buffer("inputs", inputs)
        self.register_buffer("extra", extra)

    @property
    def noise(self) -> Tensor:
        """Variance of the noise model, without the extra one."""
        return self.inner.noise

    def forward(
        self, *params: Any, shape: torch.Size | None = None, **kwargs: Any
    ) -> LinearOperator:
        """Diagonal noise covariance; without extra variance at rows that were not fitted."""
        common = self.inner(*params, shape=shape, **kwargs)
        if not params:
            return common
        inputs = params[0] if torch.is_tensor(params[0]) else params[0][0]
        fitted = self.inputs.expand(*inputs.shape[:-2], *self.inputs.shape)
        if not torch.equal(inputs, fitted):
            return common
        return DiagLinearOperator(common.diagonal(dim1=-1, dim2=-2) + self.extra)


def believe_less(model: GPyTorchModel, observations: Observations) -> None:
    """Add the extra noise of its observations to a surrogate; without any it stays unchanged.

    Parameters
    ----------
    model : GPyTorchModel
        Not yet fitted, with a standardised outcome; changed in place.
    observations : Observations
        Observations of the surrogate.
    """
    if observations.extra is None:
        return
    transform: Any = model.outcome_transform
    variance = transform.stdvs.flatten()[0] ** 2
    extra = torch.as_tensor(observations.extra.copy()) / variance
    likelihood: Any = model.likelihood
    likelihood.noise_covar = ExtraNoise(likelihood.noise_covar, observations.train_X(), extra)
