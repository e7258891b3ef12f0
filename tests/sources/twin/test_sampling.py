"""Recorded signals on the communication grid: hold, linear, jitter, blanks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.sources.twin.sampling import sample, steps_to_cover

STEP = 1e-3


def even(rows: int, start: float = 0.0, step: float = STEP) -> NDArray[np.float64]:
    return start + np.arange(rows, dtype=np.float64) * step


@given(
    rows=st.integers(2, 60),
    start=st.floats(-1e3, 1e3),
    seed=st.integers(0, 2**32 - 1),
    jitter=st.floats(0.0, 0.49),
)
def test_a_held_sample_is_not_delayed_by_jitter_of_its_clock(
    rows: int, start: float, seed: int, jitter: float
) -> None:
    """A clock that is off by under half a step gives the rows themselves on the grid."""
    rng = np.random.default_rng(seed)
    late = jitter * STEP * rng.uniform(-1.0, 1.0, rows)
    late[0] = 0.0
    values = rng.standard_normal(rows)
    grid = even(rows, start)
    assert np.array_equal(sample(grid + late, values, grid, "hold", "x"), values)


@given(first=st.floats(-0.4, 0.4), seed=st.integers(0, 2**32 - 1), each=st.integers(1, 5))
def test_nor_where_the_first_stamp_jitters_from_which_the_grid_begins(
    first: float, seed: int, each: int
) -> None:
    rng = np.random.default_rng(seed)
    rows = 400
    time = even(rows, 1.0, each * STEP) + 0.2 * STEP * rng.uniform(-1.0, 1.0, rows)
    time[0] = 1.0 + first * STEP
    values = np.arange(rows, dtype=np.float64)
    grid = even((rows - 1) * each + 1, time[0])
    assert np.array_equal(sample(time, values, grid, "hold", "x")[::each], values)


@given(
    rows=st.integers(2, 5000),
    start=st.floats(-1e3, 1e3),
    finer=st.integers(1, 5),
    skew=st.floats(-3.9e-4, 3.9e-4),
)
def test_rows_of_another_clock_come_with_the_steps_that_they_were_made_in(
    rows: int, start: float, finer: int, skew: float
) -> None:
    """However long a recording lasts, its clock puts no row off by a step."""
    values = np.arange(rows, dtype=np.float64)
    grid = even((rows - 1) * finer + 1, start, STEP / finer)
    time = start + (1.0 + skew) * (even(rows, start) - start)
    held = sample(time, values, grid, "hold", "x")
    assert np.array_equal(held[::finer], values)


def test_rows_at_another_rate_are_held_by_their_times() -> None:
    """Negative control: 1 % is no clock."""
    held = sample(even(1001, step=1.01 * STEP), np.arange(1001.0), even(1001), "hold", "x")
    assert held[[5, 50, 500, 1000]].tolist() == [5.0, 49.0, 495.0, 990.0]


@given(rows=st.integers(2, 40), finer=st.integers(2, 20), seed=st.integers(0, 2**32 - 1))
def test_on_a_finer_grid_a_sample_is_held_until_the_next(rows: int, finer: int, seed: int) -> None:
    values = np.random.default_rng(seed).standard_normal(rows)
    grid = even((rows - 1) * finer + 1, step=STEP / finer)
    expected = np.append(np.repeat(values[:-1], finer), values[-1])
    assert np.array_equal(sample(even(rows), values, grid, "hold", "x"), expected)


@given(rows=st.integers(2, 40), slope=st.floats(-1e3, 1e3), seed=st.integers(0, 2**32 - 1))
def test_linear_interpolation_follows_a_line_between_uneven_rows(
    rows: int, slope: float, seed: int
) -> None:
    time = np.cumsum(np.random.default_rng(seed).uniform(0.5, 1.5, rows)) * STEP
    grid = np.linspace(time[0], time[-1], 77)
    line = sample(time, 2.0 + slope * time, grid, "linear", "x")
    np.testing.assert_allclose(line, 2.0 + slope * grid, rtol=1e-12, atol=1e-12)


@given(
    rows=st.integers(2, 2000),
    start=st.floats(-1e4, 1e4),
    step=st.floats(1e-5, 1e-1),
    share=st.floats(0.0, 0.95),
)
def test_the_grid_covers_the_recording_and_not_a_step_more(
    rows: int, start: float, step: float, share: float
) -> None:
    time = start + step * np.arange(rows, dtype=np.float64)
    time[-1] += share * step
    steps = steps_to_cover(time, step)
    last = time[0] + steps * step
    assert last >= time[-1] - 0.01 * step
    assert last - time[-1] < step


@pytest.mark.parametrize(("late", "steps"), [(0.0, 100), (1e-8, 100), (1e-4, 101)])
def test_a_clock_error_of_10_ns_adds_no_row(late: float, steps: int) -> None:
    time = even(101)
    time[-1] += late
    assert steps_to_cover(time, STEP) == steps


def test_a_single_row_needs_no_step() -> None:
    assert steps_to_cover(np.array([3.0]), STEP) == 0
    held = sample(np.array([3.0]), np.array([7.0]), np.array([3.0]), "hold", "x")
    assert held.tolist() == [7.0]


def test_blank_rows_were_not_sampled() -> None:
    values = np.array([np.nan, 1.0, np.nan, np.nan, 2.0, np.nan])
    held = sample(even(6), values, even(6), "hold", "x")
    assert held.tolist() == [1.0, 1.0, 1.0, 1.0, 2.0, 2.0]
    line = sample(even(6), values, even(6), "linear", "x")
    np.testing.assert_allclose(line, [1.0, 1.0, 4 / 3, 5 / 3, 2.0, 2.0])


def test_a_signal_without_values_and_an_infinite_one_are_refused() -> None:
    with pytest.raises(RecordingError, match="signal 'x': expected values to drive the twin, all"):
        sample(even(3), np.full(3, np.nan), even(3), "hold", "x")
    with pytest.raises(RecordingError, match="signal 'x': row 1 is infinite; expected a finite"):
        sample(even(3), np.array([0.0, np.inf, 0.0]), even(3), "hold", "x")
