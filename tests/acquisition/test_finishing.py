"""Probability that a run finishes: a classifier of the runs so far."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import norm

from gmfbo.acquisition.finishing import (
    DEVIATION,
    TWIN_BELIEVED,
    FinishModel,
    prior_of,
    probable,
)

CLIFF = 0.6
"""Runs with a larger first gain fail."""


def runs(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    points = np.random.default_rng(seed).random((count, 2))
    return points, points[:, 0] < CLIFF


def test_a_cliff_is_learned_from_twenty_runs() -> None:
    model = FinishModel.fit(*runs(20, 0))
    points, finished = runs(400, 1)
    right = (model.log_probability(points) > np.log(0.5)) == finished
    assert right.mean() > 0.9
    kept = probable(model.log_probability(points))
    # Negative control: two of five points fail where nothing is learned.
    assert finished[kept].mean() > 0.97 > 0.65 > finished.mean()


def test_laplaces_approximation_errs_to_the_safe_side_of_the_exact_posterior() -> None:
    model = FinishModel.fit(np.array([[0.5]]), np.array([True]))
    mean = model.elsewhere

    def weight(f: float, power: int) -> float:
        return float(norm.pdf(f, mean, DEVIATION) * norm.cdf(f) ** power)

    exact = quad(weight, -20, 25, args=(2,))[0] / quad(weight, -20, 25, args=(1,))[0]
    found = float(np.exp(model.log_probability(np.array([[0.5]]))[0]))
    # Nickisch and Rasmussen 2008: it draws probabilities towards a half.
    assert exact - 0.12 < found < exact


def test_the_word_of_a_twin_holds_far_from_runs_and_yields_to_them() -> None:
    says = prior_of(np.array([TWIN_BELIEVED, TWIN_BELIEVED]))
    model = FinishModel.fit(np.array([[0.0, 0.0], [0.05, 0.0]]), np.array([False, False]), says)
    near, far = np.exp(model.log_probability(np.array([[0.02, 0.0], [9.0, 9.0]]), says))
    assert far == pytest.approx(TWIN_BELIEVED, abs=1e-6)
    assert near < 0.5


@given(st.integers(1, 12), st.integers(0, 1000))
def test_torch_and_numpy_agree(count: int, seed: int) -> None:
    points, finished = runs(count, seed)
    model = FinishModel.fit(points, finished)
    at = np.random.default_rng(seed + 1).random((5, 2))
    expected = model.log_probability(at)
    assert np.all(expected <= 0.0)
    assert model(torch.tensor(at)).numpy() == pytest.approx(expected, abs=1e-9)


def test_where_nothing_reaches_the_least_probability_the_best_still_count() -> None:
    assert probable(np.log([0.95, 0.92, 0.5])).tolist() == [True, True, False]
    assert probable(np.log([0.7, 0.65, 0.5])).tolist() == [True, True, False]
    assert probable(np.empty(0)).size == 0
