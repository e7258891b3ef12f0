r"""Kernel over gains and information source.

c(z, z') = gamma_0(s, s') c_0(k, k') + gamma_1(s, s') c_1(k, k'),  z = [k, s]

c_i = sigma_i^2 Matern-5/2(|k - k'|, l_i): c_0 is common to twin and axis, c_1 is the twin's error.
gamma_0 = Matern-5/2(|s - s'|, l_g0): correlation of twin and axis in c_0.
gamma_1 = (1 - s)(1 - s')(1 + s s')^p: vanishes at the axis (s = 1).

With s in {0, 1} the factor (1 + s s')^p is 1 wherever gamma_1 is not 0, so p cannot be learned
from such data; it stays the constant `POLYNOMIAL_DEGREE`.

The correlation of axis and twin at equal gains is gamma_0(0, 1) / sqrt(1 + sigma_1^2 / sigma_0^2).
With l_g0 <= 1, as published, gamma_0(0, 1) <= 0.524, and even endless runs of a perfect twin
remove at most 27.5 % of the axis' variance; with l_g0 = 5 these are 0.968 and 93.7 %.

A third source, the corrected twin, is a point s_3 in [0, 1] on the same line, learned from the
data: near 1 it is as good as the axis, at 0 it equals the twin. All factors are positive
semi-definite for any s, and so is the sum of their products.
"""

from __future__ import annotations

from typing import Any

import torch
from botorch.utils.constraints import LogTransformedInterval
from gpytorch.constraints import Interval
from gpytorch.kernels import Kernel, MaternKernel, ScaleKernel
from gpytorch.priors import GammaPrior
from torch import Tensor

from gmfbo.correction.torch_setup import DTYPE
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import IS2, IS3

POLYNOMIAL_DEGREE = 1.0
SOURCE_LENGTHSCALE_LOW = 0.1


class AdaptiveSourceKernel(Kernel):
    """Covariance of inputs [gains in the unit cube, source], shape (..., n, d + 1).

    The source column holds 1 for the axis, 0 for the twin, 0.5 for the corrected twin (see
    `gmfbo.surrogate.observations`).

    Parameters
    ----------
    dimension : int
        Number of gains d.
    source_lengthscale : float or None
        l_g0, set from outside as in the publication; None learns it.
    cap : float
        Upper bound of a learned l_g0; the lower one is 0.1.
    ard : bool
        One lengthscale for each gain; otherwise isotropic, as published.
    third_source : bool
        Whether the corrected twin has a learned place s_3 between twin and axis; otherwise it
        counts as the twin, as published.

    Raises
    ------
    InputError
        `source_lengthscale` is not positive, or `cap` not above 0.1.
    """

    has_lengthscale = False

    def __init__(
        self,
        dimension: int,
        *,
        source_lengthscale: float | None = 1.0,
        cap: float = 5.0,
        ard: bool = False,
        third_source: bool = False,
    ) -> None:
        super().__init__()
        self.dimension = dimension
        lengths = dimension if ard else None
        # The priors are those of BoTorch's multi-fidelity kernel, on which the publication
        # builds: Gamma(shape 3, rate 6) for l_0, Gamma(6, 2) for l_1.
        self.shared = _scaled_matern(lengths, GammaPrior(3.0, 6.0))
        self.discrepancy = _scaled_matern(lengths, GammaPrior(6.0, 2.0))
        self.across_sources = _source_matern(source_lengthscale, cap)
        self.third_source = third_source
        if third_source:
            self.register_parameter(
                "raw_third_place", torch.nn.Parameter(torch.zeros(1, dtype=DTYPE))
            )
            self.register_constraint("raw_third_place", Interval(0.0, 1.0, initial_value=0.8))

    @property
    def source_lengthscale(self) -> Tensor:
        """l_g0, shape (1, 1)."""
        return self.across_sources.lengthscale

    @property
    def third_place(self) -> Tensor:
        """Place s_3 of the corrected twin between twin (0) and axis (1), shape (1,)."""
        if not self.third_source:
            return torch.full((1,), IS2, dtype=DTYPE)
        return self.raw_third_place_constraint.transform(self.raw_third_place)

    @property
    def source_correlation(self) -> float:
        """Correlation of axis and twin at equal gains, in [0, 1]."""
        with torch.no_grad():
            gamma_0 = matern52(self.source_lengthscale.flatten()[0] ** -2)
            ratio = self.discrepancy.outputscale / self.shared.outputscale
            return float(gamma_0 / torch.sqrt(1.0 + ratio))

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
        s1, s2 = self._place(x1[..., -1:]), self._place(x2[..., -1:])
        gains = squared_differences(x1[..., :-1], x2[..., :-1], diag)
        sources = squared_differences(s1, s2, diag)
        first, second = (s1[..., 0], s2[..., 0]) if diag else (s1, s2.transpose(-1, -2))
        gamma_0 = matern52((sources / self.source_lengthscale.square()).sum(dim=-1))
        gamma_1 = (1.0 - first) * (1.0 - second) * (1.0 + first * second).pow(POLYNOMIAL_DEGREE)
        return gamma_0 * _over_gains(self.shared, gains) + (
            gamma_1 * _over_gains(self.discrepancy, gains)
        )

    def _place(self, source: Tensor) -> Tensor:
        return torch.where(source == IS3, self.third_place.to(source), source)


class _Matern52(torch.autograd.Function):
    """Matern-5/2 of the squared distance, whose derivative has no square root to divide by."""

    @staticmethod
    def forward(ctx: Any, squared: Tensor) -> Tensor:
        r = torch.sqrt(5.0 * squared)
        decay = torch.exp(-r)
        ctx.save_for_backward(r, decay)
        return (1.0 + r + r.square() / 3.0) * decay

    @staticmethod
    def backward(ctx: Any, *gradient: Tensor) -> Tensor:
        r, decay = ctx.saved_tensors
        return gradient[0] * (-5.0 / 6.0) * (1.0 + r) * decay


def matern52(squared: Tensor) -> Tensor:
    """(1 + r + r^2 / 3) exp(-r) with r^2 = 5 `squared`, the squared distance in lengthscales."""
    return _Matern52.apply(squared)


def squared_differences(one: Tensor, other: Tensor, diag: bool) -> Tensor:
    """Per column, shape (..., n, m, d), or (..., n, d) with `diag`."""
    if diag:
        return (one - other).square()
    return (one[..., :, None, :] - other[..., None, :, :]).square()


def _over_gains(part: ScaleKernel, squared: Tensor) -> Tensor:
    lengthscale = part.base_kernel.lengthscale[0]
    return part.outputscale * matern52((squared / lengthscale.square()).sum(dim=-1))


def _scaled_matern(lengths: int | None, lengthscale_prior: GammaPrior) -> ScaleKernel:
    return ScaleKernel(
        MaternKernel(
            nu=2.5,
            ard_num_dims=lengths,
            lengthscale_prior=lengthscale_prior,
            lengthscale_constraint=LogTransformedInterval(0.02, 20.0, initial_value=0.4),
        ),
        outputscale_prior=GammaPrior(2.0, 0.15),
        outputscale_constraint=LogTransformedInterval(1e-4, 1e3, initial_value=1.0),
    )


def _source_matern(lengthscale: float | None, cap: float) -> MaternKernel:
    if lengthscale is None:
        if cap <= SOURCE_LENGTHSCALE_LOW:
            raise InputError(f"expected a cap above {SOURCE_LENGTHSCALE_LOW}, got {cap}")
        start = (SOURCE_LENGTHSCALE_LOW * cap) ** 0.5
        return MaternKernel(
            nu=2.5,
            lengthscale_constraint=LogTransformedInterval(
                SOURCE_LENGTHSCALE_LOW, cap, initial_value=start
            ),
        )
    if lengthscale <= 0.0:
        raise InputError(f"expected a positive source lengthscale, got {lengthscale}")
    kernel = MaternKernel(nu=2.5).to(DTYPE)
    kernel.lengthscale = torch.tensor(lengthscale, dtype=DTYPE)
    kernel.raw_lengthscale.requires_grad_(False)
    return kernel
