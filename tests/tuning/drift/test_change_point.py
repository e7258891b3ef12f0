"""Evidence of a change: false alarms, delay, and what it must not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import null_space

from gmfbo.correction.matern import matern52
from gmfbo.tuning.drift.change_point import (
    FALSE_ALARM_RATE,
    LEAST_SINCE,
    ChangeEvidence,
    _log_likelihood,
    combined,
    log_statistic,
)

Array = NDArray[np.float64]


def drawn(
    rng: np.random.Generator, count: int, lengthscale: float, noise: float
) -> tuple[Array, Array]:
    """Random gains, and values of a Gaussian process there with a variance of 1."""
    points = rng.random((count, 2))
    covariance = matern52(points, points, lengthscale) + noise * np.eye(count)
    return points, np.linalg.cholesky(covariance) @ rng.standard_normal(count)


def alarm(points: Array, values: Array) -> int | None:
    """Runs after which the statistic first reaches the threshold."""
    for count in range(LEAST_SINCE + 1, len(values) + 1):
        ratios = ChangeEvidence.of(points[:count], values[:count]).log_ratios
        if log_statistic(ratios[: 1 - LEAST_SINCE]) >= -np.log(FALSE_ALARM_RATE):
            return count
    return None


def test_likelihood_without_mean_and_scale_is_that_of_contrasts_of_any_scale() -> None:
    rng = np.random.default_rng(1)
    points = rng.random((6, 2))
    values, others = rng.standard_normal((2, 6))
    covariance = matern52(points, points, 0.4) + 0.1 * np.eye(6)
    contrasts = null_space(np.ones((1, 6))).T
    within = contrasts @ covariance @ contrasts.T

    def of_contrasts(y: Array) -> float:
        # With the prior 1 / s of the scale, of n - 1 contrasts that do not see the mean.
        z = contrasts @ y
        return float(
            -0.5 * np.linalg.slogdet(within)[1] - 2.5 * np.log(z @ np.linalg.solve(within, z))
        )

    ours = _log_likelihood(covariance, values) - _log_likelihood(covariance, others)
    assert float(ours) == pytest.approx(of_contrasts(values) - of_contrasts(others))
    rough = 0.3 * covariance + np.diag(rng.random(6))
    other_within = contrasts @ rough @ contrasts.T
    z = contrasts @ values
    expected = of_contrasts(values) - float(
        -0.5 * np.linalg.slogdet(other_within)[1]
        - 2.5 * np.log(z @ np.linalg.solve(other_within, z))
    )
    got = _log_likelihood(covariance, values) - _log_likelihood(rough, values)
    assert float(got) == pytest.approx(expected)


@pytest.mark.parametrize(("lengthscale", "noise"), [(0.5, 1e-4), (2.0, 0.1)])
def test_ratios_have_an_expectation_of_at_most_one_without_a_change(
    lengthscale: float, noise: float
) -> None:
    rng = np.random.default_rng(3)
    ratios = np.array(
        [
            np.exp(ChangeEvidence.of(*drawn(rng, 7, lengthscale, noise)).log_ratios)
            for _ in range(150)
        ]
    )
    assert np.all(ratios.mean(axis=0) < 1.0)


def test_false_alarms_are_no_more_than_stated() -> None:
    rng = np.random.default_rng(5)
    studies, runs = 60, 12
    alarms = 0
    for study in range(studies):
        lengthscale, noise = [(0.5, 1e-4), (2.0, 0.1), (0.3, 1e-2)][study % 3]
        alarms += alarm(*drawn(rng, runs, lengthscale, noise)) is not None
    # 1.8 of them are expected at most.
    assert alarms <= studies * runs * FALSE_ALARM_RATE


@pytest.mark.parametrize(("shift", "most_delay"), [(2.0, 6.0), (4.0, 2.0)])
def test_a_shift_is_found_within_a_few_runs(shift: float, most_delay: float) -> None:
    rng = np.random.default_rng(7)
    delays = []
    for _ in range(9):
        points, values = drawn(rng, 16, 0.6, 1e-3)
        values[8:] += shift
        found = alarm(points, values)
        delays.append(np.inf if found is None else found - 8)
    # A large shift may already tell with its first run, and is then placed a run early.
    assert min(delays) >= 1
    assert np.median(delays) <= most_delay


def test_the_change_is_placed_where_it_was() -> None:
    points, values = drawn(np.random.default_rng(2), 14, 0.6, 1e-3)
    values[6:] += 5.0
    evidence = ChangeEvidence.of(points, values)
    assert int(np.argmax(evidence.log_ratios)) + 1 == 6
    assert evidence.shares[5] > 1.0


def test_a_repeat_that_differs_is_stronger_than_the_same_value_elsewhere() -> None:
    points, values = drawn(np.random.default_rng(4), 8, 0.6, 1e-4)
    shifted = np.append(values, values[[0, 1]] + 1.0)
    repeated = ChangeEvidence.of(np.vstack([points, points[[0, 1]]]), shifted)
    elsewhere = ChangeEvidence.of(np.vstack([points, 1.0 - points[[0, 1]]]), shifted)
    assert repeated.log_ratios[7] > elsewhere.log_ratios[7] + 1.0


def test_units_and_offsets_do_not_matter() -> None:
    points, values = drawn(np.random.default_rng(6), 9, 0.5, 1e-2)
    one, other = ChangeEvidence.of(points, values), ChangeEvidence.of(points, 40.0 + 1e-3 * values)
    np.testing.assert_allclose(one.log_ratios, other.log_ratios, atol=1e-6)


def test_values_that_are_equal_say_nothing() -> None:
    points = np.random.default_rng(0).random((12, 2))
    ratios = ChangeEvidence.of(points, np.full(12, 3.0)).log_ratios
    np.testing.assert_array_equal(ratios, np.zeros(11))
    assert alarm(points, np.full(12, 3.0)) is None


def test_several_values_are_averaged() -> None:
    together = combined([np.log([1.0, 4.0]), np.log([3.0, 2.0])])
    np.testing.assert_allclose(np.exp(together), [2.0, 3.0])
