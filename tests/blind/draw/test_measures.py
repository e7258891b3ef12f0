"""Calibration, clustered shares and what is left of an error, against what is known of each."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import expit, logit

from tests.blind.draw.measures import (
    NORMAL,
    clopper_pearson,
    clustered_share,
    error_left,
    recalibration,
)


@pytest.mark.parametrize(("intercept", "slope"), [(0.0, 1.0), (-1.0, 1.0), (0.0, 0.4)])
def test_recalibration_finds_the_line_that_outcomes_were_drawn_from(
    intercept: float, slope: float
) -> None:
    rng = np.random.default_rng(3)
    held = np.zeros(2)
    for _ in range(40):
        p = rng.uniform(0.05, 0.99, 2000)
        right = rng.random(2000) < expit(intercept + slope * logit(p))
        fitted = recalibration(list(p), list(right))
        assert fitted is not None
        held += np.abs(fitted[0] - (intercept, slope)) < NORMAL * fitted[1]
    assert held.min() >= 34  # 38 of 40 on the average


def test_a_forecast_of_one_that_fails_counts_as_the_last_printed_digit() -> None:
    fitted = recalibration([1.0] * 200 + [0.5] * 40, [True] * 199 + [False] + [True, False] * 20)
    assert fitted is not None
    assert fitted[0] == pytest.approx([0.0, 1.0], abs=0.01)


@pytest.mark.parametrize(
    ("stated", "right"),
    [
        ([], []),
        ([0.9, 0.8], [True, True]),
        ([0.9, 0.9], [True, False]),
        ([0.9, 0.95, 0.6], [True, True, False]),
        ([0.6, 0.95], [True, False]),
    ],
)
def test_claims_that_cannot_tell_a_line_give_none(stated: list[float], right: list[bool]) -> None:
    assert recalibration(stated, right) is None


def test_trials_that_are_clusters_of_their_own_have_the_interval_of_a_share() -> None:
    held = [True] * 90 + [False] * 10
    low, high = clustered_share(held, range(100))
    assert (low, high) == pytest.approx(clopper_pearson(90, 100), abs=0.03)
    assert clustered_share([], []) == (0.0, 1.0)
    # Nothing scatters where all are alike: the exact interval of as many trials as clusters.
    assert clustered_share([True] * 40, [k // 2 for k in range(40)]) == clopper_pearson(20, 20)
    assert clustered_share([True, True], [0, 0]) == clopper_pearson(1, 1)


def test_trials_that_fail_together_are_fewer_than_they_seem() -> None:
    held = [True] * 90 + [False] * 10
    alone = np.diff(clustered_share(held, range(100)))
    together = np.diff(clustered_share(held, [k // 10 for k in range(100)]))
    assert together > 2.0 * alone


def errors(*signals: tuple[float, float | None, float]) -> dict[str, object]:
    """Parameters alone, augmented and noise floor of each signal."""
    names = ("parameters_only", "augmented", "noise_floor")
    return {
        "fit": {
            "signals": {str(k): dict(zip(names, s, strict=True)) for k, s in enumerate(signals)}
        }
    }


@pytest.mark.parametrize(
    ("signals", "expected"),
    [
        ([(5.0, 1.0, 1.0)], 0.0),
        ([(5.0, 5.0, 1.0)], 1.0),
        ([(5.0, None, 1.0)], 1.0),  # nothing named: the twin stays
        ([(3.0, 2.0, 1.0)], 3.0 / 8.0),
        ([(3.0, 2.0, 1.0), (30.0, 10.0, 10.0)], 3.0 / 16.0),  # each in its noise, not its unit
        ([(1.05, 1.0, 1.0)], None),
        ([], None),
    ],
)
def test_error_left_is_one_of_the_twin_and_none_at_the_noise(
    signals: list[tuple[float, float | None, float]], expected: float | None
) -> None:
    assert error_left(errors(*signals)) == (None if expected is None else pytest.approx(expected))


def test_the_exact_interval_is_the_published_one() -> None:
    """0 of 150 is at most 2.4 %; 1 of 10 is 0.25 to 44.5 % (Clopper, Pearson 1934)."""
    assert clopper_pearson(0, 150) == pytest.approx((0.0, 0.0243), abs=1e-4)
    assert clopper_pearson(1, 10) == pytest.approx((0.00253, 0.445), abs=1e-3)
    assert clopper_pearson(3, 3)[1] == 1.0
    assert clopper_pearson(0, 0) == (0.0, 1.0)
