"""Expected improvement against numerical integration, and the trade of improvement for cost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import norm

from gmfbo.acquisition.improvement import (
    CostAwareExpectedImprovement,
    log_expected_improvement,
    log_improvement,
)
from gmfbo.errors import InputError
from gmfbo.surrogate.model import SourceModel, SurrogateSettings
from gmfbo.surrogate.observations import Observations


def scalar(value: float) -> torch.Tensor:
    return torch.tensor(value, dtype=torch.float64)


def integrated(mean: float, sigma: float, incumbent: float) -> float:
    """Integral of max(incumbent - g, 0) over the posterior of g."""
    value, _ = quad(
        lambda g: (incumbent - g) * norm.pdf(g, mean, sigma),
        min(incumbent, mean) - 12.0 * sigma,
        incumbent,
        epsabs=0.0,
        epsrel=1e-9,
        limit=400,
    )
    return float(value)


@pytest.mark.parametrize("incumbent", [-2.0, -0.5, 0.0, 0.3, 2.5])
@pytest.mark.parametrize("sigma", [0.2, 1.0, 3.0])
def test_closed_form_equals_the_integral(incumbent: float, sigma: float) -> None:
    truth = integrated(0.1, sigma, incumbent)
    logarithm = log_expected_improvement(scalar(0.1), scalar(sigma), incumbent).item()
    assert logarithm == pytest.approx(math.log(truth), abs=1e-7)


@pytest.mark.parametrize("u", [-0.999, -1.001, -5.0, -40.0, -999.0, -1001.0, -1e6])
def test_logarithm_does_not_underflow_and_its_branches_meet(u: float) -> None:
    # log(phi(u) + u Phi(u)) by the continued fraction of the Mills ratio, exact for u < -5, by
    # SciPy's functions above.
    ours = log_expected_improvement(scalar(-u), scalar(1.0), 0.0).item()
    if u > -5.0:
        truth = math.log(norm.pdf(u) + u * norm.cdf(u))
    else:
        series = 1.0 - 3.0 / u**2 + 15.0 / u**4 - 105.0 / u**6 + 945.0 / u**8 - 10395.0 / u**10
        truth = norm.logpdf(u) - 2.0 * math.log(-u) + math.log(series)
    assert ours == pytest.approx(truth, rel=1e-4 if u == -5.0 else 1e-10)


@given(mean=st.floats(-10.0, 10.0), sigma=st.floats(1e-6, 10.0), incumbent=st.floats(-10.0, 10.0))
def test_logarithm_and_gradient_are_finite_and_point_downhill(
    mean: float, sigma: float, incumbent: float
) -> None:
    inputs = torch.tensor([mean, sigma], dtype=torch.float64, requires_grad=True)
    value = log_expected_improvement(inputs[0], inputs[1], incumbent)
    (gradient,) = torch.autograd.grad(value, inputs)
    assert torch.isfinite(value)
    assert torch.isfinite(gradient).all()
    assert gradient[0] <= 0.0
    assert gradient[1] >= -1e-12 / sigma  # where improvement is certain, 1/sigma cancels


def test_arrays_give_the_same_numbers() -> None:
    mean, variance = np.array([0.0, 1.0]), np.array([0.25, 4.0])
    ours = log_improvement(mean, variance, 0.5)
    for index in range(2):
        truth = integrated(mean[index], math.sqrt(variance[index]), 0.5)
        assert ours[index] == pytest.approx(math.log(truth), abs=1e-7)


@pytest.fixture(scope="module")
def model() -> SourceModel:
    rng = np.random.default_rng(0)
    points = rng.random((24, 2))
    sources = tuple(["IS1"] * 8 + ["IS2"] * 16)
    values = np.sin(4.0 * points[:, 0]) + (points[:, 1] - 0.5) ** 2
    values[8:] += 0.2 * points[8:, 1]
    settings = SurrogateSettings(source_lengthscale=None)
    return SourceModel.fit(Observations(points, sources, values), settings)


def at(column: float, *points: list[float]) -> torch.Tensor:
    return torch.tensor([[[*point, column]] for point in points], dtype=torch.float64)


POINTS = ([0.2, 0.3], [0.9, 0.5], [0.5, 0.1])


@pytest.mark.parametrize(("source", "column", "cost"), [("IS1", 1.0, 1.0), ("IS2", 0.0, 0.25)])
def test_acquisition_is_improvement_over_its_own_incumbent_less_the_cost(
    model: SourceModel, source: str, column: float, cost: float
) -> None:
    incumbents, costs = {"IS1": 0.1, "IS2": -0.2}, {"IS1": 1.0, "IS2": 0.25}
    acquisition = CostAwareExpectedImprovement(model, incumbents, costs)
    with torch.no_grad():
        values = acquisition(at(column, *POINTS))
    mean, variance = model.predict(POINTS, source)
    for index in range(3):
        truth = integrated(mean[index], math.sqrt(variance[index]), incumbents[source]) / cost
        assert values[index].item() == pytest.approx(math.log(truth), abs=1e-5)


def test_cheaper_source_is_preferred_by_exactly_its_cost(model: SourceModel) -> None:
    incumbents = {"IS1": 0.0, "IS2": 0.0}
    dear = CostAwareExpectedImprovement(model, incumbents, {"IS1": 1.0, "IS2": 1.0})
    cheap = CostAwareExpectedImprovement(model, incumbents, {"IS1": 1.0, "IS2": 0.1})
    with torch.no_grad():
        gain = cheap(at(0.0, *POINTS)) - dear(at(0.0, *POINTS))
        same = cheap(at(1.0, *POINTS)) - dear(at(1.0, *POINTS))
    np.testing.assert_allclose(gain, math.log(10.0), rtol=1e-12)
    np.testing.assert_array_equal(same, 0.0)


def test_sources_may_be_mixed_in_one_batch(model: SourceModel) -> None:
    acquisition = CostAwareExpectedImprovement(
        model, {"IS1": 0.1, "IS2": -0.2}, {"IS1": 1.0, "IS2": 0.25}
    )
    mixed = torch.cat([at(1.0, POINTS[0]), at(0.0, POINTS[1]), at(1.0, POINTS[2])])
    with torch.no_grad():
        together = acquisition(mixed)
        alone = torch.cat([acquisition(row[None]) for row in mixed])
    np.testing.assert_allclose(together, alone, rtol=1e-9)


def test_twin_valued_by_the_axis_is_worth_its_correlation_of_the_axis(model: SourceModel) -> None:
    acquisition: Any = CostAwareExpectedImprovement(
        model, {"IS1": 0.1}, {"IS1": 1.0, "IS2": 1.0}, value="axis"
    )
    with torch.no_grad():
        axis, twin = acquisition(at(1.0, *POINTS)), acquisition(at(0.0, *POINTS))
    _, first = model.predict(POINTS, "IS1")
    _, second = model.predict(POINTS, "IS2")
    correlation = np.abs(model.covariance(POINTS, "IS1", "IS2")) / np.sqrt(first * second)
    np.testing.assert_allclose(twin - axis, np.log(correlation), atol=1e-4)
    assert torch.all(twin <= axis)


def test_missing_costs_and_incumbents_are_refused(model: SourceModel) -> None:
    with pytest.raises(InputError, match="positive query cost for IS2, got 0"):
        CostAwareExpectedImprovement(model, {"IS2": 0.0}, {"IS2": 0.0})
    with pytest.raises(InputError, match="no incumbent for IS2"):
        CostAwareExpectedImprovement(model, {"IS1": 0.0}, {"IS2": 0.5})
    only_axis = CostAwareExpectedImprovement(model, {"IS1": 0.0}, {"IS1": 1.0})
    with pytest.raises(InputError, match="no query cost for source column 0"):
        only_axis(at(0.0, POINTS[0]))
