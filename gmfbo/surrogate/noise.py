"""Gaussian noise with one variance for all sources, or one for each."""

from __future__ import annotations

from typing import Any

import torch
from botorch.utils.constraints import LogTransformedInterval
from gpytorch.likelihoods import _GaussianLikelihoodBase
from gpytorch.likelihoods.noise_models import Noise
from gpytorch.priors import LogNormalPrior
from linear_operator.operators import DiagLinearOperator
from torch import Tensor

from gmfbo.correction.torch_setup import DTYPE
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import SOURCE_COLUMN

_COLUMNS = tuple(SOURCE_COLUMN.values())


class SourceNoise(Noise):
    """Noise variance by source column, in units of the standardised objective squared.

    Parameters
    ----------
    per_source : bool
        One variance for each source; otherwise one for all, as published.
    floor : float
        Least variance. Simulated objectives are exact, and a floor of 1e-4 (GPyTorch's) blurs
        them.
    """

    def __init__(self, *, per_source: bool, floor: float) -> None:
        super().__init__()
        self.per_source = per_source
        count = len(_COLUMNS) if per_source else 1
        self.register_parameter("raw_noise", torch.nn.Parameter(torch.zeros(count, dtype=DTYPE)))
        # BoTorch's log-normal noise prior (Hvarfner et al. 2024, loc -4, scale 1), but wider, since
        # runs of a simulator repeat exactly.
        self.register_prior(
            "noise_prior",
            LogNormalPrior(-6.0, 2.0),
            lambda module: module.noise,
            lambda module, value: module.initialize(
                raw_noise=module.raw_noise_constraint.inverse_transform(value)
            ),
        )
        self.register_constraint(
            "raw_noise", LogTransformedInterval(floor, 1.0, initial_value=max(1e-3, 2 * floor))
        )

    @property
    def noise(self) -> Tensor:
        """Variances, shape (3,) in the order IS1, IS2, IS3, or (1,)."""
        return self.raw_noise_constraint.transform(self.raw_noise)

    def forward(
        self, *params: Any, shape: torch.Size | None = None, **kwargs: Any
    ) -> DiagLinearOperator:
        """Diagonal noise covariance at inputs of shape (..., n, d + 1)."""
        if not params:
            raise InputError(
                "noise by source needs the inputs; call the marginal likelihood with them: "
                "mll(output, targets, train_inputs)"
            )
        inputs = params[0] if torch.is_tensor(params[0]) else params[0][0]
        noise = self.noise
        if self.per_source:
            column = inputs[..., -1]
            diagonal = sum(
                torch.where(column == value, noise[index], torch.zeros_like(column))
                for index, value in enumerate(_COLUMNS)
            )
        else:
            diagonal = noise.expand(inputs.shape[:-1])
        return DiagLinearOperator(diagonal)


class SourceNoiseLikelihood(_GaussianLikelihoodBase):
    """Gaussian likelihood whose variance may depend on the source; see `SourceNoise`."""

    def __init__(self, *, per_source: bool = False, floor: float = 1e-6) -> None:
        super().__init__(noise_covar=SourceNoise(per_source=per_source, floor=floor))

    @property
    def noise(self) -> Tensor:
        """Variances, shape (3,) in the order IS1, IS2, IS3, or (1,)."""
        return self.noise_covar.noise
