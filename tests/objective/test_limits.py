"""Limits on metrics: which are met, by how much the others are not, and how probable that is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from gmfbo.errors import InputError
from gmfbo.objective.limits import Limits, log_feasibility


def test_a_limit_is_met_up_to_its_value() -> None:
    limits = Limits({"overshoot": 5.0})
    assert limits.met({"overshoot": 5.0, "rise_time": 9.0})
    assert limits.excess({"overshoot": 7.5}) == pytest.approx(0.5)
    assert Limits().met({"overshoot": 90.0})


def test_of_several_references_the_worst_counts() -> None:
    limits = Limits({"overshoot": 5.0})
    metrics = {"overshoot": 4.0, "overshoot[1]": 1.0, "overshoot[2]": 7.0, "overshoots": 99.0}
    assert limits.limited(metrics) == {"overshoot": 7.0}
    assert not limits.met(metrics)


def test_probability_of_feasibility_is_the_normal_distribution() -> None:
    mean, variance = np.array([0.0, 5.0, 9.0]), np.array([4.0, 1.0, 4.0])
    expected = norm.cdf(5.0, loc=mean, scale=np.sqrt(variance))
    np.testing.assert_allclose(np.exp(log_feasibility(mean, variance, 5.0)), expected)


def test_it_stays_finite_far_beyond_the_limit_and_without_variance() -> None:
    log = log_feasibility([1e6, 4.0], [0.0, 0.0], 5.0)
    assert np.isfinite(log).all()
    assert log[0] < -1e6
    assert log[1] == 0.0


def test_a_limit_must_be_a_number() -> None:
    with pytest.raises(InputError, match="expected a number for 'overshoot'"):
        Limits({"overshoot": float("nan")})
