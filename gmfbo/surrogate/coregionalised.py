r"""Coregionalised surrogate: the correlation of axis and twin is learned.

Intrinsic coregionalisation (Bonilla, Chai and Williams 2008; in Bayesian optimisation Swersky,
Snoek and Adams 2013): one covariance over the gains, and a learned 2 x 2 matrix over the sources,

c(z, z') = B[s, s'] Matern-5/2(|k - k'|, l),  B = [[a^2, rho a b], [rho a b, b^2]],  0 <= rho < 1.

Each source has a mean of its own, so that a twin which is merely too low or too high by a
constant still correlates with the axis. The logit of rho has a normal prior, median rho 2/3 and
quartiles 0.39 and 0.86, since two or three runs of the axis cannot determine rho. (BoTorch's
`MultiTaskGP` takes Beta(2.5, 1.5), of the same mean and a little narrower.)
"""

from __future__ import annotations

from typing import Any

import torch
from botorch.utils.constraints import LogTransformedInterval
from gpytorch.constraints import Interval
from gpytorch.kernels import Kernel, MaternKernel
from gpytorch.means import Mean
from gpytorch.priors import GammaPrior, LogNormalPrior, NormalPrior
from torch import Tensor

from gmfbo.correction.fitting import fit_by_map
from gmfbo.correction.torch_setup import DTYPE
from gmfbo.surrogate.extra_noise import believe_less
from gmfbo.surrogate.kernel import matern52, squared_differences
from gmfbo.surrogate.model import SourceModel
from gmfbo.surrogate.noise import SourceNoiseLikelihood
from gmfbo.surrogate.observations import IS1, Observations

MOST_CORRELATION = 0.999


class CoregionalisedKernel(Kernel):
    """Covariance of inputs [gains in the unit cube, source], shape (..., n, d + 1).

    Parameters
    ----------
    dimension : int
        Number of gains d.
    """

    has_lengthscale = False

    def __init__(self, dimension: int) -> None:
        super().__init__()
        self.over_gains = MaternKernel(
            nu=2.5,
            ard_num_dims=dimension,
            lengthscale_prior=GammaPrior(3.0, 6.0),
            lengthscale_constraint=LogTransformedInterval(0.02, 20.0, initial_value=0.4),
        )
        self.register_parameter("raw_scales", torch.nn.Parameter(torch.zeros(2, dtype=DTYPE)))
        self.register_constraint("raw_scales", LogTransformedInterval(1e-2, 30.0, initial_value=1))
        self.register_prior("scales_prior", LogNormalPrior(0.0, 1.0), lambda kernel: kernel.scales)
        self.register_parameter("raw_correlation", torch.nn.Parameter(torch.zeros(1, dtype=DTYPE)))
        self.register_constraint(
            "raw_correlation", Interval(0.0, MOST_CORRELATION, initial_value=2.0 / 3.0)
        )
        self.register_prior(
            "correlation_prior", NormalPrior(0.69, 1.7), lambda kernel: kernel.raw_correlation
        )

    @property
    def scales(self) -> Tensor:
        """Standard deviations of axis a and twin b, shape (2,)."""
        return self.raw_scales_constraint.transform(self.raw_scales)

    @property
    def correlation(self) -> Tensor:
        """Correlation rho of axis and twin at equal gains, shape (1,)."""
        return self.raw_correlation_constraint.transform(self.raw_correlation)

    @property
    def source_correlation(self) -> float:
        """`correlation` as a number."""
        return float(self.correlation.detach())

    def forward(
        self,
        x1: Tensor,
        x2: Tensor,
        diag: bool = False,
        last_dim_is_batch: bool = False,
        **params: Any,
    ) -> Tensor:
        """Covariance, shape (..., n, m), or (..., n) with `diag`."""
        if last_dim_is_batch:
            raise NotImplementedError("gains and source cannot be split into single columns")
        first, second = x1[..., -1], x2[..., -1]
        if not diag:
            first, second = first[..., :, None], second[..., None, :]
        a, b = self.scales
        sources = torch.where(first == IS1, a, b) * torch.where(second == IS1, a, b)
        shared = torch.where(first == second, torch.ones_like(a), self.correlation[0])
        squared = squared_differences(x1[..., :-1], x2[..., :-1], diag)
        lengthscale = self.over_gains.lengthscale[0]
        return sources * shared * matern52((squared / lengthscale.square()).sum(dim=-1))


class SourceMean(Mean):
    """One constant for the axis and one for the twin, in units of the standardised objective."""

    def __init__(self) -> None:
        super().__init__()
        self.register_parameter("constants", torch.nn.Parameter(torch.zeros(2, dtype=DTYPE)))
        self.register_prior("constants_prior", NormalPrior(0.0, 1.0), lambda mean: mean.constants)

    def forward(self, x: Tensor) -> Tensor:
        """Mean, shape (..., n), at inputs of shape (..., n, d + 1)."""
        return torch.where(x[..., -1] == IS1, self.constants[0], self.constants[1])


class CoregionalisedModel(SourceModel):
    """`SourceModel` with `CoregionalisedKernel` and `SourceMean`, one noise for each source."""

    @classmethod
    def fit_sources(cls, observations: Observations) -> CoregionalisedModel:
        """Fit by maximum a posteriori; the same data gives the same model.

        Parameters
        ----------
        observations : Observations
            Runs of axis and twin.
        """
        inputs = observations.train_X()
        model = cls(
            inputs,
            observations.train_Y(),
            covar_module=CoregionalisedKernel(inputs.shape[-1] - 1),
            likelihood=SourceNoiseLikelihood(per_source=True),
            mean_module=SourceMean(),
        )
        believe_less(model, observations)
        model.note = fit_by_map(model)
        return model

    def hyperparameters(self) -> dict[str, float]:
        """Fitted numbers by name, for a log; lengthscales in the unit cube."""
        kernel = self.covar_module
        scales, lengths = kernel.scales.detach(), kernel.over_gains.lengthscale.detach().flatten()
        return {
            "scale.IS1": float(scales[0]),
            "scale.IS2": float(scales[1]),
            **{f"lengthscale[{column}]": float(v) for column, v in enumerate(lengths)},
            "source_correlation": kernel.source_correlation,
        }
