"""Mismatch of the twin on known numbers, and what follows from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gmfbo.errors import InputError
from gmfbo.objective.mismatch import (
    query_cost,
    relative_mismatch,
    scaled_mismatch,
    source_lengthscale,
)


def test_printed_mismatch_is_the_mean_of_relative_errors() -> None:
    assert relative_mismatch([2.0, -4.0], [1.0, -5.0]) == pytest.approx((0.5 + 0.25) / 2)


def test_printed_mismatch_is_ruled_by_one_objective_near_zero_and_the_scaled_one_is_not() -> None:
    corrected, twin = np.array([1.0, 1.0, 1.0, 0.001]), np.array([1.1, 1.1, 1.1, 0.101])
    assert relative_mismatch(corrected, twin) > 20.0
    assert scaled_mismatch(corrected, twin) == pytest.approx(0.1)


def test_zero_objectives_do_not_divide_by_zero() -> None:
    assert relative_mismatch([0.0, 0.0], [0.0, 0.0]) == 0.0
    assert np.isfinite(relative_mismatch([0.0, 1.0], [0.5, 1.0]))


def test_without_any_pair_the_twin_is_taken_to_be_wholly_off() -> None:
    assert relative_mismatch([], []) == 1.0
    assert scaled_mismatch([], []) == 1.0


@pytest.mark.parametrize(
    ("mismatch", "lengthscale", "cost"),
    [
        (0.0, 1.0, 0.1),
        (0.05, 1.0, 0.1),
        (0.5, 1.0, 0.5),
        (2.0, 0.5, 1.0),
        (100.0, 0.1, 1.0),
    ],
)
def test_lengthscale_and_cost_follow_the_clamps(
    mismatch: float, lengthscale: float, cost: float
) -> None:
    assert source_lengthscale(mismatch) == pytest.approx(lengthscale)
    assert query_cost(mismatch) == pytest.approx(cost)


@given(st.floats(0.0, 1e9), st.floats(0.0, 1e9))
def test_as_printed_lengthscale_and_cost_never_adapt_together(first: float, second: float) -> None:
    # The trap: below e = 1 only the cost moves, above it only the lengthscale.
    both = source_lengthscale(first) != source_lengthscale(second) and query_cost(
        first
    ) != query_cost(second)
    assert not (both and (first - 1.0) * (second - 1.0) > 0.0)


def test_objectives_that_cannot_be_compared_are_refused() -> None:
    with pytest.raises(InputError, match=r"give Objective\.scaled values, not g"):
        scaled_mismatch([-0.1], [0.2])
    with pytest.raises(InputError, match="pairs of objectives"):
        relative_mismatch([1.0, 2.0], [1.0])
    with pytest.raises(InputError, match="price failed runs"):
        relative_mismatch([np.nan], [1.0])
