"""Tables whose noise is known: what the prior makes of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.retuning.table_prior import (
    BEND,
    LEAST_NOISE,
    TablePrior,
    differences,
    second_differences,
)

SHAPE = (5, 6)
ROWS, COLUMNS = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 6), indexing="ij")
PLANE = (3.0 * ROWS - 2.0 * COLUMNS + 7.0).ravel()


@given(st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3))
def test_a_plane_has_no_second_differences(weights: list[float]) -> None:
    plane = weights[0] * ROWS + weights[1] * COLUMNS + weights[2]
    assert second_differences(SHAPE) @ plane.ravel() == pytest.approx(0.0, abs=1e-12)


def test_second_differences_of_a_parabola_are_those_of_the_closed_form() -> None:
    parabola = np.arange(7.0) ** 2
    assert second_differences((7,)) @ parabola == pytest.approx(np.full(5, 2.0))


def test_differences_follow_their_axis() -> None:
    table = np.arange(12.0).reshape(3, 4)
    assert differences((3, 4), 0) @ table.ravel() == pytest.approx(np.full(8, 4.0))
    assert differences((3, 4), 1) @ table.ravel() == pytest.approx(np.full(9, 1.0))


def test_a_smooth_table_is_left_alone() -> None:
    prior = TablePrior.of(PLANE, SHAPE)
    assert prior.noise == LEAST_NOISE
    assert prior.scale == pytest.approx(np.ptp(PLANE))
    assert prior.smoothing_change == pytest.approx(0.0, abs=1e-9)


def test_noise_is_found_by_its_roughness() -> None:
    # Median over 40 draws; one draw of 30 nodes is off by some 15 %.
    found = []
    for seed in range(40):
        noisy = PLANE + 0.5 * np.ptp(PLANE) * np.random.default_rng(seed).standard_normal(30)
        prior = TablePrior.of(noisy, SHAPE)
        found.append(prior.noise * prior.scale / np.ptp(PLANE))
    assert np.median(found) == pytest.approx(0.5, rel=0.15)


def test_smoothing_brings_a_noisy_table_nearer_to_the_truth() -> None:
    gains = []
    for seed in range(20):
        noise = 0.5 * np.ptp(PLANE) * np.random.default_rng(seed).standard_normal(30)
        prior = TablePrior.of(PLANE + noise, SHAPE)
        gains.append(np.std(noise + prior.smoothing_change) / np.std(noise))
    assert np.median(gains) < 0.6


@pytest.mark.parametrize("rising", [None, 0, 1])
def test_slope_of_the_rows_is_their_derivative(rising: int | None) -> None:
    rng = np.random.default_rng(3)
    prior = TablePrior.of(PLANE + rng.standard_normal(30), SHAPE, rising)
    change, step = rng.standard_normal(30), 1e-7 * rng.standard_normal(30)
    moved = (prior.rows(change + step) - prior.rows(change - step)) / 2.0
    assert prior.slope_of_rows(change) @ step == pytest.approx(moved, rel=1e-5, abs=1e-11)


def test_a_table_that_should_rise_pays_for_falling_and_not_for_rising() -> None:
    rising = TablePrior.of(np.arange(5.0), (5,), 0)
    free = TablePrior.of(np.arange(5.0), (5,))
    steps = len(rising.rows(np.zeros(5))) - len(free.rows(np.zeros(5)))
    assert steps == 4
    assert rising.rows(np.zeros(5))[-4:] == pytest.approx(0.0)
    turned = rising.rows(-2.0 * np.arange(5.0))[-4:]
    assert np.all(turned < 0.0)


def test_bend_is_the_spread_of_what_the_prior_expects() -> None:
    parabola = 0.5 * BEND * np.arange(5.0) ** 2
    prior = TablePrior.of(parabola, (5,))
    bends = prior.rows(np.zeros(5))[5:8] * prior.scale
    assert bends == pytest.approx(np.ones(3))
