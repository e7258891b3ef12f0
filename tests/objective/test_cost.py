"""The weighted cost against its formula, and the price of a failed run."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.errors import InputError
from gmfbo.objective.cost import PAPER_WEIGHTS, Objective
from gmfbo.objective.metrics import METRICS, worst_metrics


def sample_metrics(count: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    samples = {name: rng.uniform(0.05, 0.9, count) for name in METRICS}
    return {**samples, "overshoot": rng.uniform(0.0, 40.0, count)}


@pytest.fixture
def objective() -> Objective:
    return Objective.from_samples(PAPER_WEIGHTS, sample_metrics(10), horizon=1.0)


def test_cost_is_the_weighted_sum_of_z_scores(objective: Objective) -> None:
    samples = sample_metrics(10)
    expected = sum(
        weight * (samples[name] - samples[name].mean()) / samples[name].std(ddof=1)
        for name, weight in PAPER_WEIGHTS.items()
    )
    np.testing.assert_allclose(objective.value(samples), expected, atol=1e-12)
    assert np.mean(objective.value(samples)) == pytest.approx(0.0, abs=1e-12)


def test_cost_and_scaled_cost_differ_by_a_constant(objective: Objective) -> None:
    samples = sample_metrics(25)
    difference = objective.scaled(samples) - objective.value(samples)
    np.testing.assert_allclose(difference, difference[0], atol=1e-12)
    assert np.all(objective.scaled(samples) >= 0.0)


metric_values = st.fixed_dictionaries(
    {name: st.floats(0.0, 1e9, allow_nan=False) for name in METRICS}
)


@given(metric_values)
def test_no_run_costs_more_than_a_failed_one(values: dict[str, float]) -> None:
    objective = Objective.from_samples(PAPER_WEIGHTS, sample_metrics(10), horizon=1.0)
    assert objective.value(values) <= objective.failed + 1e-12
    assert np.isfinite(objective.failed)


def test_a_failed_run_is_priced_as_full_overshoot_that_never_settles(objective: Objective) -> None:
    worst = worst_metrics(1.0)
    assert worst == {
        "overshoot": 100.0,
        "transient_time": 1.0,
        "rise_time": 1.0,
        "settling_time": 1.0,
    }
    assert objective.failed == objective.value(worst)


def test_a_metric_that_no_sample_moved_is_scaled_by_one_percent_of_its_worst() -> None:
    samples = {**sample_metrics(10), "overshoot": np.zeros(10)}
    objective = Objective.from_samples(PAPER_WEIGHTS, samples, horizon=2.0)
    assert objective.std["overshoot"] == 1.0
    assert np.isfinite(objective.value(worst_metrics(2.0)))


def test_without_two_samples_the_worst_case_is_the_scale() -> None:
    samples = {name: values[:1] for name, values in sample_metrics(3).items()}
    objective = Objective.from_samples({"rise_time": 2.0}, samples, horizon=4.0)
    assert objective.value({"rise_time": 2.0}) == pytest.approx(1.0)


def test_an_unknown_metric_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"no metric 'rise'; did you mean 'rise_time'\?"):
        Objective.from_samples({"rise": 1.0}, sample_metrics(4), horizon=1.0)


def test_a_negative_weight_is_refused() -> None:
    with pytest.raises(InputError, match="'overshoot' must be zero or more, got -1"):
        Objective.from_samples({"overshoot": -1.0}, sample_metrics(4), horizon=1.0)


def test_no_weights_are_refused() -> None:
    with pytest.raises(InputError, match="at least one of overshoot"):
        Objective.from_samples({}, sample_metrics(4), horizon=1.0)
