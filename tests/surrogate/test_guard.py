"""When a twin is dropped: often enough if it misleads, and seldom if it does not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.errors import InputError
from gmfbo.surrogate.guard import TwinGuard

GUARD = TwinGuard()


def test_a_twin_that_loses_everywhere_is_dropped() -> None:
    alone = np.linspace(0.1, 1.0, 6)
    assert not GUARD.trusts(3.0 * alone, alone)


def test_a_twin_that_wins_is_kept() -> None:
    alone = np.linspace(0.1, 1.0, 12)
    assert GUARD.trusts(0.3 * alone, alone)


def test_a_twin_as_good_as_none_is_dropped_as_often_as_the_level_says() -> None:
    """1000 draws at level 0.1; six binomial standard deviations are 0.057."""
    rng = np.random.default_rng(0)
    dropped = [not GUARD.trusts(*rng.standard_normal((2, 12))) for _ in range(1000)]
    assert np.mean(dropped) < 0.1 + 0.057


def test_a_twin_with_twice_the_error_is_dropped_mostly() -> None:
    rng = np.random.default_rng(1)
    dropped = [
        not GUARD.trusts(2.0 * rng.standard_normal(20), rng.standard_normal(20)) for _ in range(200)
    ]
    assert np.mean(dropped) > 0.7


def test_one_run_that_jumps_decides_nothing() -> None:
    alone = np.full(8, 0.5) + np.linspace(0.0, 0.01, 8)
    twin = 0.5 * alone
    twin[3] = 1000.0
    assert GUARD.trusts(twin, alone)


def test_few_runs_drop_no_twin() -> None:
    assert GUARD.trusts([9.0, 8.0, 7.0, 6.0], [0.1, 0.2, 0.3, 0.4])
    assert not GUARD.trusts([9.0, 8.0, 7.0, 6.0, 5.0], [0.1, 0.2, 0.3, 0.4, 0.5])


def test_runs_without_an_error_do_not_count() -> None:
    nan = float("nan")
    assert GUARD.trusts([9.0, 8.0, 7.0, 6.0, nan], [0.1, 0.2, 0.3, 0.4, 0.5])


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=1, max_size=15),
    st.sampled_from([0.125, 0.5, 2.0, 1024.0]),
)
def test_signs_and_units_of_the_errors_do_not_matter(
    pairs: list[tuple[float, float]], unit: float
) -> None:
    twin, alone = np.array(pairs).T
    assert GUARD.trusts(twin, alone) == GUARD.trusts(-unit * twin, unit * alone)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-5, 5), min_size=1, max_size=15))
def test_equal_errors_keep_the_twin(errors: list[float]) -> None:
    assert GUARD.trusts(errors, errors)


def test_wrong_arguments_are_refused() -> None:
    with pytest.raises(InputError, match=r"level within \(0, 1\)"):
        TwinGuard(level=1.5)
    with pytest.raises(InputError, match=r"of the same runs, got shapes \(2,\) and \(3,\)"):
        GUARD.trusts([1.0, 2.0], [1.0, 2.0, 3.0])
