"""Left-out misfit of linear problems, against refits by hand; gains that chance alone gives."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.linear_left_out import normal_equations, sums_of_others

Blocks = tuple[NDArray[np.float64], ...]


def linear_problem(
    rng: np.random.Generator, groups: int, columns: int, rows: int = 40
) -> tuple[Blocks, Blocks]:
    """Residuals and columns of as many windows as groups."""
    residual = tuple(rng.standard_normal(rows) for _ in range(groups))
    return residual, tuple(rng.standard_normal((columns, rows)) for _ in range(groups))


def refitted_without(
    residual: Blocks, columns: Blocks, prior: NDArray[np.float64], g: int
) -> float:
    """Square in group g after a ridge fit on all others, by least squares over stacked rows."""
    others = [i for i in range(len(residual)) if i != g]
    a = np.vstack([*(columns[i].T for i in others), np.diag(np.sqrt(prior))])
    b = np.concatenate([*(residual[i] for i in others), np.zeros(prior.size)])
    change = np.linalg.lstsq(a, b, rcond=None)[0]
    return float(np.sum((residual[g] - columns[g].T @ change) ** 2))


@given(st.integers(2, 6), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_the_square_left_out_is_that_of_a_refit_on_the_others(
    groups: int, columns: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    residual, sensitivity = linear_problem(rng, groups, columns)
    prior = rng.uniform(0.01, 10.0, columns)
    normal = normal_equations(residual, sensitivity, range(groups), prior)
    expected = [refitted_without(residual, sensitivity, prior, g) for g in range(groups)]
    np.testing.assert_allclose(normal.left_out(), expected, rtol=1e-7)


def test_columns_of_very_different_sizes_are_solved_alike() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(1), 4, 3)
    sizes = np.array([1e-9, 1.0, 1e9])
    plain = normal_equations(residual, sensitivity, range(4)).left_out()
    scaled = normal_equations(
        residual, tuple(sizes[:, None] * a for a in sensitivity), range(4)
    ).left_out()
    np.testing.assert_allclose(scaled, plain, rtol=1e-6)


def test_windows_of_one_group_are_left_out_together() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(2), 4, 2)
    normal = normal_equations(residual, sensitivity, [0, 0, 1, 1])
    joined = tuple(np.concatenate(residual[i : i + 2]) for i in (0, 2))
    stacked = tuple(np.concatenate(sensitivity[i : i + 2], axis=1) for i in (0, 2))
    np.testing.assert_allclose(
        normal.left_out(), normal_equations(joined, stacked, [0, 1]).left_out()
    )


def test_a_single_group_has_nothing_left_out_and_is_scored_by_its_own_fit() -> None:
    residual, sensitivity = linear_problem(np.random.default_rng(3), 1, 2)
    normal = normal_equations(residual, sensitivity, [0])
    fitted = residual[0] - normal.solution() @ sensitivity[0]
    np.testing.assert_allclose(normal.left_out(), [fitted @ fitted])


def test_sums_of_others_lose_nothing_to_a_group_that_outweighs_them() -> None:
    values = np.array([1e12, 0.25, 0.5])
    np.testing.assert_array_equal(sums_of_others(values)[0], 0.75)
