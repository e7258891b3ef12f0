"""Bootstrap intervals against normal theory."""

from __future__ import annotations

import numpy as np
import pytest

from gmfbo.studies.bootstrap import Interval


def test_interval_of_a_mean_is_that_of_normal_theory() -> None:
    sample = np.random.default_rng(4).normal(7.0, 2.0, size=400)
    interval = Interval.of(sample, np.mean)
    half = 1.96 * sample.std() / np.sqrt(sample.size)
    assert interval.value == pytest.approx(sample.mean())
    # 4000 draws give the ends of the interval to about 3 % of its half.
    assert interval.low == pytest.approx(sample.mean() - half, abs=0.1 * half)
    assert interval.high == pytest.approx(sample.mean() + half, abs=0.1 * half)


def test_interval_of_a_median_holds_the_median() -> None:
    interval = Interval.of([3.0, 5.0, 8.0, 23.0, 23.0], np.median)
    assert interval.value == 8.0
    assert interval.low <= 8.0 <= interval.high
    assert {interval.low, interval.high} <= {3.0, 5.0, 8.0, 23.0}


def test_equal_values_leave_no_doubt() -> None:
    assert Interval.of([4.0] * 6, np.mean) == Interval(4.0, 4.0, 4.0)


def test_same_sample_gives_the_same_interval() -> None:
    sample = [1.0, 4.0, 9.0]
    assert Interval.of(sample, np.mean) == Interval.of(sample, np.mean)
