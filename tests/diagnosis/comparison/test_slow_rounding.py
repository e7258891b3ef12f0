"""Columns of slow rounding have the covariance that rounding has."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.noise.slow_rounding import between_counts, slow_rounding

COUNT = 0.4
RAMP = COUNT * np.linspace(0.0, 3.0, 400)
SWING = COUNT * 2.5 * np.sin(np.linspace(0.0, 6.0, 400))


def bernoulli(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance of rounding with a count that begins anywhere (Widrow and Kollar 2008)."""
    apart = np.mod((path[:, None] - path) / COUNT, 1.0)
    return 0.5 * COUNT**2 * (apart**2 - apart + 1.0 / 6.0)


@pytest.mark.parametrize("path", [RAMP, SWING])
def test_their_covariance_is_the_closed_form(path: NDArray[np.float64]) -> None:
    columns = slow_rounding(path, COUNT, 0.0)
    assert np.allclose(columns.T @ columns, bernoulli(path), atol=0.1 * COUNT**2 / 12.0)


def test_it_is_that_of_rounded_readings() -> None:
    begins = np.random.default_rng(0).uniform(0.0, COUNT, 20_000)[:, None]
    read = COUNT * np.round((SWING[::20] + begins) / COUNT) - SWING[::20] - begins
    found = read.T @ read / len(begins)
    chance = 5.0 * COUNT**2 / 12.0 / np.sqrt(len(begins))
    assert np.allclose(found, bernoulli(SWING[::20]), atol=chance)


def test_noise_before_the_rounding_spreads_it() -> None:
    """As readings of a held axis show, whose mean noise brings nearer to the truth."""
    rng, noise = np.random.default_rng(1), 0.25 * COUNT
    begins = rng.uniform(0.0, COUNT, 400)[:, None]
    read = COUNT * np.round((begins + noise * rng.standard_normal((400, 2000))) / COUNT)
    off = float(np.mean((read.mean(1) - begins[:, 0]) ** 2))
    columns = slow_rounding(np.zeros(20), COUNT, noise)
    assert columns[:, 0] @ columns[:, 0] == pytest.approx(off, rel=0.15)
    assert not len(slow_rounding(np.zeros(20), COUNT, COUNT))


def test_what_moves_by_counts_a_row_has_none() -> None:
    assert not len(slow_rounding(COUNT * 1.7 * np.arange(50.0), COUNT, 0.0))


def test_a_path_between_counts_is_right_where_they_change() -> None:
    read = COUNT * np.round(SWING / COUNT)
    path = between_counts(read)
    assert np.max(np.abs(path - SWING)) <= COUNT
    changes = np.flatnonzero(np.diff(read))
    rate = np.max(np.abs(np.diff(SWING)))
    assert np.max(np.abs(path - SWING)[changes]) <= rate
    assert np.array_equal(between_counts(np.full(9, 2.0)), np.full(9, 2.0))
