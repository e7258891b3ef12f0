"""The learned correlation of axis and twin, against the one that data were drawn with."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from gmfbo.correction.matern import matern52
from gmfbo.surrogate.coregionalised import CoregionalisedKernel, CoregionalisedModel
from gmfbo.surrogate.observations import Observations, with_source

LENGTH, REAL, TWIN = 0.4, 25, 40


def drawn(correlation: float, seed: int, *, offset: float = 0.0) -> Observations:
    """Axis and twin drawn with a known correlation at equal gains."""
    rng = np.random.default_rng(seed)
    points = rng.random((REAL + TWIN, 2))
    covariance = matern52(points, points, LENGTH) + 1e-9 * np.eye(len(points))
    one, other = np.linalg.cholesky(covariance) @ rng.standard_normal((len(points), 2)).T[..., None]
    axis = one[:, 0]
    twin = correlation * axis + np.sqrt(1.0 - correlation**2) * other[:, 0] + offset
    sources = ("IS1",) * REAL + ("IS2",) * TWIN
    return Observations(points, sources, np.where(np.arange(len(points)) < REAL, axis, twin))


@pytest.mark.parametrize(("true", "most_error"), [(0.1, 0.25), (0.5, 0.2), (0.95, 0.1)])
def test_learned_correlation_is_near_the_true_one(true: float, most_error: float) -> None:
    learned = [
        CoregionalisedModel.fit_sources(drawn(true, seed)).covar_module.source_correlation
        for seed in range(5)
    ]
    assert abs(np.mean(learned) - true) < most_error


def test_a_twin_that_is_off_by_a_constant_keeps_its_correlation() -> None:
    near, far = (
        CoregionalisedModel.fit_sources(drawn(0.95, 1, offset=offset)) for offset in (0.0, 5.0)
    )
    assert far.covar_module.source_correlation > 0.75
    assert near.covar_module.source_correlation > 0.75


def test_a_good_twin_tells_of_the_axis_where_the_axis_never_ran() -> None:
    rng = np.random.default_rng(3)
    points = rng.random((34, 2))

    def cost(where: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sin(6.0 * where[:, 0]) + where[:, 1]

    twin = cost(points) + 1.0
    values = np.where(np.arange(34) < 4, cost(points), twin)
    model = CoregionalisedModel.fit_sources(
        Observations(points, ("IS1",) * 4 + ("IS2",) * 30, values)
    )
    asked = rng.random((50, 2))
    mean, variance = model.predict(asked, "IS1")
    assert np.sqrt(np.mean((mean - cost(asked)) ** 2)) < 0.25 * cost(asked).std()
    assert np.all(variance >= 0.0)


def test_kernel_is_the_product_of_sources_and_gains() -> None:
    kernel = CoregionalisedKernel(2)
    points = np.random.default_rng(4).random((6, 2))
    a, b = kernel.scales.detach().numpy()
    rho, length = kernel.source_correlation, float(kernel.over_gains.lengthscale[0, 0].detach())
    shared = matern52(points, points, length)
    both = torch.cat([with_source(points, "IS1"), with_source(points, "IS2")])
    expected = np.kron([[a * a, rho * a * b], [rho * a * b, b * b]], shared)
    covariance = kernel.forward(both, both)
    np.testing.assert_allclose(covariance.detach().numpy(), expected, rtol=1e-6)
    np.testing.assert_allclose(
        kernel.forward(both, both, diag=True).detach().numpy(), np.diag(expected), rtol=1e-6
    )
    assert np.linalg.eigvalsh(expected).min() > 0.0


def test_numbers_for_a_log_are_finite() -> None:
    numbers = CoregionalisedModel.fit_sources(drawn(0.5, 0)).hyperparameters()
    assert set(numbers) >= {"scale.IS1", "scale.IS2", "lengthscale[1]", "source_correlation"}
    assert all(np.isfinite(list(numbers.values())))
