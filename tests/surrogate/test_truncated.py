"""BoTorch's multi-fidelity surrogate: its kernel in closed form, and what follows from it."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from botorch.models.kernels.linear_truncated_fidelity import LinearTruncatedFidelityKernel
from numpy.typing import NDArray

from gmfbo.correction.matern import matern52
from gmfbo.surrogate.observations import Observations, with_source
from gmfbo.surrogate.truncated import TruncatedModel


def axis(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sin(5.0 * points[:, 0]) + 4.0 * (points[:, 1] - 0.4) ** 2


@pytest.fixture(scope="module")
def model() -> TruncatedModel:
    points = np.random.default_rng(0).random((16, 2))
    sources = ("IS1",) * 4 + ("IS2",) * 12
    twin = np.where(np.arange(16) < 4, 0.0, 0.3 * points[:, 0])
    return TruncatedModel.fit(Observations(points, sources, axis(points) + twin))


def test_kernel_is_the_linear_truncated_one(model: TruncatedModel) -> None:
    points = np.random.default_rng(1).random((5, 2))
    scale = float(model.covar_module.outputscale.detach())
    (truncated,) = (
        module
        for module in model.covar_module.modules()
        if isinstance(module, LinearTruncatedFidelityKernel)
    )
    parts = []
    for kernel in (truncated.covar_module_unbiased, truncated.covar_module_biased):
        lengths = kernel.lengthscale.detach().numpy()[0]
        parts.append(matern52(points / lengths, points / lengths, 1.0))
    shared, bias = parts

    def covariance(one: str, other: str) -> NDArray[np.float64]:
        dense = model.covar_module(with_source(points, one), with_source(points, other)).to_dense()
        return np.asarray(dense.detach().numpy())

    np.testing.assert_allclose(covariance("IS1", "IS1"), scale * shared, rtol=1e-6)
    np.testing.assert_allclose(covariance("IS1", "IS2"), scale * shared, rtol=1e-6)
    np.testing.assert_allclose(covariance("IS2", "IS2"), scale * (shared + bias), rtol=1e-6)


def test_correlation_of_axis_and_twin_is_fixed(model: TruncatedModel) -> None:
    both = torch.cat([with_source([0.3, 0.6], "IS1"), with_source([0.3, 0.6], "IS2")])
    covariance = model.covar_module(both).to_dense().detach().numpy()
    correlation = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert correlation == pytest.approx(np.sqrt(0.5), rel=1e-6)


def test_runs_of_the_axis_are_reproduced(model: TruncatedModel) -> None:
    points = np.random.default_rng(0).random((16, 2))[:4]
    mean, variance = model.predict(points, "IS1")
    np.testing.assert_allclose(mean, axis(points), atol=0.1)
    assert np.all(variance >= 0.0)


def test_same_data_gives_the_same_model_whatever_the_generator_did() -> None:
    points = np.random.default_rng(2).random((9, 2))
    data = Observations(points, ("IS1",) * 3 + ("IS2",) * 6, axis(points))
    first = TruncatedModel.fit(data).predict([[0.2, 0.8]], "IS1")
    torch.rand(7)
    second = TruncatedModel.fit(data).predict([[0.2, 0.8]], "IS1")
    np.testing.assert_array_equal(first, second)
