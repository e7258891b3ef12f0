"""The kernel against its formula, and positive semi-definite whatever comes in."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from gpytorch.distributions import MultivariateNormal
from gpytorch.likelihoods import GaussianLikelihood
from gpytorch.means import ConstantMean
from gpytorch.models import ExactGP
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from torch import Tensor

from gmfbo.errors import InputError
from gmfbo.surrogate.kernel import AdaptiveSourceKernel
from gmfbo.surrogate.kernel import matern52 as matern52_of_squares


def matern52(distance: float, lengthscale: float) -> float:
    r = math.sqrt(5.0) * distance / lengthscale
    return (1.0 + r + r * r / 3.0) * math.exp(-r)


def inputs(*rows: list[float]) -> Tensor:
    return torch.tensor(rows, dtype=torch.float64)


def set_kernel(kernel: AdaptiveSourceKernel, v0: float, l0: float, v1: float, l1: float) -> None:
    kernel.double()
    # Tensors, because GPyTorch rounds plain numbers to float32.
    values = torch.tensor([v0, l0, v1, l1], dtype=torch.float64)
    kernel.shared.outputscale, kernel.discrepancy.outputscale = values[0], values[2]
    kernel.shared.base_kernel.lengthscale = values[1]
    kernel.discrepancy.base_kernel.lengthscale = values[3]


@pytest.mark.parametrize(
    ("lengthscale", "gamma_0"),
    [(1.0, 0.524), (0.5, 0.139), (0.4, 0.064), (0.2, 7.5e-4), (0.1, 3.7e-8), (5.0, 0.968)],
)
def test_shared_part_across_sources_has_the_published_values(
    lengthscale: float, gamma_0: float
) -> None:
    kernel = AdaptiveSourceKernel(2, source_lengthscale=lengthscale)
    set_kernel(kernel, 1.0, 0.5, 2e-4, 2.0)
    value = kernel(inputs([0.2, 0.7, 1.0]), inputs([0.2, 0.7, 0.0])).to_dense().item()
    assert value == pytest.approx(matern52(1.0, lengthscale), rel=1e-12)
    assert value == pytest.approx(gamma_0, rel=2e-2)


def test_capped_correlation_leaves_most_of_the_axis_unknown() -> None:
    # Share of the axis' variance that endless runs of a perfect twin remove: correlation^2.
    for lengthscale, removed in ((1.0, 0.275), (5.0, 0.937)):
        kernel = AdaptiveSourceKernel(1, source_lengthscale=lengthscale)
        set_kernel(kernel, 1.0, 0.5, 2e-4, 2.0)
        assert kernel.source_correlation**2 == pytest.approx(removed, abs=1e-3)


def test_every_entry_follows_the_formula() -> None:
    kernel = AdaptiveSourceKernel(2, source_lengthscale=0.7, third_source=True)
    set_kernel(kernel, 2.0, 0.4, 3.0, 1.5)
    kernel.initialize(
        raw_third_place=kernel.raw_third_place_constraint.inverse_transform(
            torch.tensor([0.75], dtype=torch.float64)
        )
    )
    rows = [[0.1, 0.2, 1.0], [0.6, 0.9, 0.0], [0.3, 0.3, 0.5], [0.1, 0.2, 0.0]]
    matrix = kernel(inputs(*rows)).to_dense().detach().numpy()
    for i, first in enumerate(rows):
        for j, second in enumerate(rows):
            s, t = (0.75 if row[2] == 0.5 else row[2] for row in (first, second))
            distance = math.dist(first[:2], second[:2])
            shared = matern52(abs(s - t), 0.7) * 2.0 * matern52(distance, 0.4)
            error = (1 - s) * (1 - t) * (1 + s * t) * 3.0 * matern52(distance, 1.5)
            assert matrix[i, j] == pytest.approx(shared + error, rel=1e-10)
    diagonal = kernel(inputs(*rows), diag=True).detach().numpy()
    np.testing.assert_allclose(diagonal, np.diag(matrix), rtol=1e-12)


def test_ard_stretches_each_gain_on_its_own() -> None:
    kernel = AdaptiveSourceKernel(2, ard=True).double()
    kernel.shared.base_kernel.lengthscale = torch.tensor([0.1, 10.0], dtype=torch.float64)
    axis = kernel(inputs([0.0, 0.0, 1.0]), inputs([0.3, 0.0, 1.0], [0.0, 0.3, 1.0])).to_dense()
    scale = float(kernel.shared.outputscale.detach())
    assert axis[0, 0].item() == pytest.approx(scale * matern52(0.3, 0.1), rel=1e-10)
    assert axis[0, 1].item() == pytest.approx(scale * matern52(0.3, 10.0), rel=1e-10)


def test_corrected_twin_counts_as_the_twin_unless_it_is_a_source_of_its_own() -> None:
    printed = AdaptiveSourceKernel(1)
    same = printed(inputs([0.4, 0.5], [0.4, 0.0])).to_dense()
    assert torch.equal(same[0], same[1])
    own = AdaptiveSourceKernel(1, source_lengthscale=None, third_source=True)
    towards_axis = own(inputs([0.4, 1.0]), inputs([0.4, 0.5], [0.4, 0.0])).to_dense()[0]
    assert towards_axis[0] > towards_axis[1]


@given(
    rows=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.sampled_from([0.0, 0.5, 1.0])),
        min_size=2,
        max_size=12,
    ),
    lengthscale=st.floats(0.1, 5.0),
    place=st.floats(0.01, 0.99),
    scales=st.tuples(st.floats(0.01, 100.0), st.floats(0.01, 100.0)),
)
def test_positive_semidefinite_for_any_mix_of_sources(
    rows: list[tuple[float, float, float]],
    lengthscale: float,
    place: float,
    scales: tuple[float, float],
) -> None:
    kernel = AdaptiveSourceKernel(2, source_lengthscale=lengthscale, third_source=True)
    set_kernel(kernel, scales[0], 0.3, scales[1], 1.0)
    kernel.initialize(
        raw_third_place=kernel.raw_third_place_constraint.inverse_transform(
            torch.tensor([place], dtype=torch.float64)
        )
    )
    matrix: NDArray[np.float64] = (
        kernel(torch.tensor(rows, dtype=torch.float64)).to_dense().detach().numpy()
    )
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-12 * matrix.max())
    assert np.linalg.eigvalsh(matrix).min() >= -1e-12 * np.trace(matrix)


def test_works_in_a_plain_gpytorch_model() -> None:
    class Process(ExactGP):  # type: ignore[misc]
        def __init__(self, x: Tensor, y: Tensor, likelihood: GaussianLikelihood) -> None:
            super().__init__(x, y, likelihood)
            self.mean_module = ConstantMean()
            self.covar_module = AdaptiveSourceKernel(1)

        def forward(self, x: Tensor) -> MultivariateNormal:
            return MultivariateNormal(self.mean_module(x), self.covar_module(x))

    x = inputs([0.1, 1.0], [0.5, 0.0], [0.9, 1.0])
    likelihood = GaussianLikelihood().double()
    likelihood.noise = 1e-4
    process = Process(x, torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64), likelihood).double()
    process.eval()
    mean = process(inputs([0.1, 1.0], [0.9, 1.0])).mean
    np.testing.assert_allclose(mean.detach(), [1.0, 3.0], atol=1e-2)


def test_impossible_lengthscales_are_refused() -> None:
    with pytest.raises(InputError, match="positive source lengthscale, got 0"):
        AdaptiveSourceKernel(2, source_lengthscale=0.0)
    with pytest.raises(InputError, match=r"cap above 0\.1"):
        AdaptiveSourceKernel(2, source_lengthscale=None, cap=0.1)


def test_gradient_is_that_of_finite_differences_and_finite_at_zero_distance() -> None:
    squared = torch.tensor([1e-3, 0.1, 2.0, 30.0], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(matern52_of_squares, (squared,))
    nothing = torch.zeros(1, dtype=torch.float64, requires_grad=True)
    (slope,) = torch.autograd.grad(matern52_of_squares(nothing).sum(), nothing)
    assert slope.item() == pytest.approx(-5.0 / 6.0)
