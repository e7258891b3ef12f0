"""Steps of a parabola within bounds, against its minimum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from gmfbo.diagnosis.fitting.bounded_step import bounded_step

SIZE = 4


def parabola(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Curvature, slope, and a root of the curvature."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((SIZE, SIZE)) + 2.0 * np.eye(SIZE)
    return root.T @ root, rng.standard_normal(SIZE), root


@given(st.integers(0, 10_000))
def test_without_bounds_it_ends_at_the_minimum(seed: int) -> None:
    matrix, slope, _ = parabola(seed)
    far = np.full(SIZE, np.inf)
    found = bounded_step(matrix, slope, np.ones(SIZE, dtype=bool), -far, far)
    np.testing.assert_allclose(matrix @ found, slope, atol=1e-8)


@given(st.integers(0, 10_000), st.floats(0.01, 2.0), st.integers(0, SIZE - 1))
def test_it_stays_within_its_bounds_and_gains(seed: int, most: float, held: int) -> None:
    matrix, slope, _ = parabola(seed)
    free = np.arange(SIZE) != held
    ends = np.full(SIZE, most)
    found = bounded_step(matrix, slope, free, -ends, ends)
    assert found[held] == 0.0
    assert np.abs(found).max() <= most
    assert slope @ found - 0.5 * found @ matrix @ found >= -1e-12


@pytest.mark.parametrize("seed", range(5))
def test_with_one_bound_that_is_met_it_is_the_minimum_within(seed: int) -> None:
    matrix, slope, root = parabola(seed)
    whole = np.linalg.solve(matrix, slope)
    ends = np.full(SIZE, np.inf)
    ends[0] = 0.5 * abs(whole[0])
    found = bounded_step(matrix, slope, np.ones(SIZE, dtype=bool), -ends, ends)
    aim = np.linalg.solve(root.T, slope)
    exact = lsq_linear(root, aim, (-ends, ends), tol=1e-14).x
    np.testing.assert_allclose(found, exact, atol=1e-6)
