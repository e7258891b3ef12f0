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
def test_mean_is_that_of_a_direct_solve(
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


def test_departures_are_what_the_others_do_not_predict(
    runs: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    points, functions = runs
    extra = np.full(7, 0.3)
    process = ResidualProcess.fit(points, functions, lengthscale=LENGTHSCALE, extra=extra)
    found = process.departures(0.3, 2)
    for row, run in zip(found, (5, 6), strict=False):
        others = np.arange(7) != run
        rest = ResidualProcess.fit(
            points[others], functions[others], lengthscale=LENGTHSCALE, extra=extra[others]
        )
        missed = functions[run] - rest.mean(points[[run]])[0]
        np.testing.assert_allclose(row / np.linalg.norm(row), missed / np.linalg.norm(missed))
    np.testing.assert_array_equal(found[:2], -found[2:])


def test_departures_have_the_covariance_of_a_repeated_run() -> None:
    """Functions of a process with S = 1 at one time, between runs that share much."""
    rng = np.random.default_rng(3)
    points, extra = np.sort(rng.random((9, 1)), axis=0), np.full(9, 0.3 - NUGGET)
    distance = np.sqrt(5.0) * np.abs(points - points.T) / LENGTHSCALE
    matrix = (1.0 + distance + distance**2 / 3.0) * np.exp(-distance) + 0.3 * np.eye(9)
    drawn = np.linalg.cholesky(matrix) @ rng.standard_normal((9, 20_000))
    process = ResidualProcess.fit(points, drawn, lengthscale=LENGTHSCALE, extra=extra)
    found = process.departures(0.3, 9)[:9]
    np.testing.assert_allclose(np.mean(found**2, axis=1), 0.3, rtol=0.05)


def test_runs_are_reproduced_and_nothing_is_claimed_far_from_them(
    runs: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    points, functions = runs
    process = ResidualProcess.fit(points, functions, lengthscale=0.1)
    np.testing.assert_allclose(process.mean(points), functions, atol=1e-2)
    far = np.array([[9.0, 9.0]])
    np.testing.assert_allclose(process.mean(far), 0.0, atol=1e-12)


def test_without_runs_the_residual_is_zero() -> None:
    process = ResidualProcess.fit(np.empty((0, 2)), np.empty((0, 30)), lengthscale=LENGTHSCALE)
    asked = np.array([[0.5, 0.5]])
    np.testing.assert_array_equal(process.mean(asked), np.zeros((1, 30)))
