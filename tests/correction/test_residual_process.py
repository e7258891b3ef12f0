"""The process over whole trajectories against a direct solve, time by time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.correction.residual_process import NUGGET, ResidualProcess

TIME = np.linspace(0.0, 1.0, 30)
LENGTHSCALE = 0.5


def matern52(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    distance = np.linalg.norm(one[:, None, :] - other[None, :, :], axis=-1)
    r = np.sqrt(5.0) * distance / LENGTHSCALE
    return np.asarray((1.0 + r + r**2 / 3.0) * np.exp(-r))


@pytest.fixture
def runs() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    points = np.random.default_rng(0).random((7, 2))
    return points, np.sin(3.0 * points[:, :1] + 6.0 * TIME) + points[:, 1:]


@pytest.mark.parametrize("centred", [False, True])
def test_mean_and_share_are_those_of_a_direct_solve(
    runs: tuple[NDArray[np.float64], NDArray[np.float64]], centred: bool
) -> None:
    points, functions = runs
    process = ResidualProcess.fit(points, functions, lengthscale=LENGTHSCALE, centred=centred)
    asked = np.random.default_rng(1).random((5, 2))
    centre = functions.mean(axis=0) if centred else 0.0
    matrix = matern52(points, points) + NUGGET * np.eye(7)
    weights = np.linalg.solve(matrix, matern52(points, asked)).T
    np.testing.assert_allclose(
        process.mean(asked), centre + weights @ (functions - centre), rtol=1e-6, atol=1e-8
    )
    left = 1.0 - np.sum(weights * matern52(asked, points), axis=1)
    np.testing.assert_allclose(process.share(asked), np.sqrt(left), rtol=1e-5)


def test_runs_are_reproduced_and_nothing_is_claimed_far_from_them(
    runs: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    points, functions = runs
    process = ResidualProcess.fit(points, functions, lengthscale=0.1)
    np.testing.assert_allclose(process.mean(points), functions, atol=1e-2)
    assert process.share(points).max() < 0.02
    far = np.array([[9.0, 9.0]])
    np.testing.assert_allclose(process.mean(far), 0.0, atol=1e-12)
    np.testing.assert_allclose(process.share(far), 1.0)


def test_draws_have_the_covariance_over_time_that_the_runs_imply(
    runs: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    points, functions = runs
    process = ResidualProcess.fit(points, functions, lengthscale=LENGTHSCALE)
    draws = process.deviations(40000, np.random.default_rng(2))
    # Maximum likelihood of the covariance over time: R' C^-1 R / n.
    matrix = matern52(points, points) + NUGGET * np.eye(7)
    truth = functions.T @ np.linalg.solve(matrix, functions) / 7
    # 40000 draws: standard error 0.7 % of a variance, so 4 % fails by chance practically never.
    np.testing.assert_allclose(draws.T @ draws / 40000, truth, atol=0.04 * np.diag(truth).max())


def test_without_runs_the_residual_is_zero() -> None:
    process = ResidualProcess.fit(np.empty((0, 2)), np.empty((0, 30)), lengthscale=LENGTHSCALE)
    asked = np.array([[0.5, 0.5]])
    np.testing.assert_array_equal(process.mean(asked), np.zeros((1, 30)))
    np.testing.assert_array_equal(
        process.deviations(3, np.random.default_rng(3)), np.zeros((3, 30))
    )
