"""Jitter up to a tenth of the mean step is even, more is told; gaps and equal times are refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.clock import check_clock, unrounded


def check(time: NDArray[np.floating[Any]]) -> str:
    return check_clock(
        "run.csv",
        time.astype(np.float64),
        [np.ones(time.size, dtype=np.bool_)],
        lambda k: f"row {k + 1}",
    )


@given(
    step=st.floats(1e-6, 10.0),
    start=st.floats(-1e3, 1e3),
    shifts=st.lists(st.floats(-0.045, 0.045), min_size=3, max_size=50),
)
def test_small_jitter_on_any_clock_is_accepted(
    step: float, start: float, shifts: list[float]
) -> None:
    # Instants off by 4.5 % make steps off by at most 9 %, and move the mean by 3 % at most.
    shifts[0] = shifts[-1] = 0.0
    assert check((start + np.arange(len(shifts)) + np.array(shifts)) * step) == ""


@given(rows=st.integers(20, 200), late=st.data())
def test_one_late_row_is_named(rows: int, late: st.DataObject) -> None:
    row = late.draw(st.integers(2, rows - 2))
    time = 1e-3 * np.arange(rows, dtype=np.float64)
    time[row:] += 2e-4
    assert "rows come 0.001 to 0.0012 s apart: the twin runs at its own step" in check(time)
    time[row:] += 2e-3
    with pytest.raises(RecordingError, match=rf"row {row + 1}, at .* a gap of 0\.0032 s"):
        check(time)


def test_a_lost_row_is_no_gap_and_two_in_a_row_are() -> None:
    time = 1e-3 * np.arange(100, dtype=np.float64)
    assert "0.001 to 0.002 s apart" in check(np.delete(time, 50))
    with pytest.raises(RecordingError, match=r"a gap of 0.003 s, .* resample = 0.001 in the twin"):
        check(np.delete(time, [50, 51]))


def test_seconds_since_1970_have_no_jitter_of_their_own() -> None:
    """Near 1.7e9 s the nearest numbers lie 0.24 us apart: 2.4 % of a 10 us step."""
    check(1.7e9 + 1e-5 * np.arange(1000))


def test_one_or_two_rows_have_no_jitter() -> None:
    check(np.array([5.0]))
    check(np.array([5.0, 6.0]))


def test_gaps_are_not_excused_by_a_column_with_blanks() -> None:
    time = np.array([0.0, 1.0, 2.0, 5.0, 6.0])
    full, blanks = np.ones(5, dtype=np.bool_), np.array([True, True, True, False, False])
    with pytest.raises(RecordingError, match="row 4, at 5 s: there is a gap of 3 s"):
        check_clock("run.csv", time, [full, blanks], lambda k: f"row {k + 1}")


@given(
    spacing=st.integers(21, 99).filter(lambda k: k % 10),
    rows=st.integers(100, 3000),
    begins=st.floats(0.0, 0.9),
)
def test_even_rows_on_a_clock_of_whole_milliseconds_are_even_again(
    spacing: int, rows: int, begins: float
) -> None:
    """Rows each 2.1 to 9.9 ms: the times come back to within the digit that was left out."""
    even = 1e-4 * spacing * np.arange(rows) + 1e-3 * begins
    written = np.round(even, 3).astype(np.float64)
    found = unrounded(written)
    if check(written) == "":
        return  # steps differ by less than a tenth
    assert found is not None
    time, digit = found
    assert digit == pytest.approx(1e-3)
    assert np.abs(time - even).max() <= 1e-3
    assert np.diff(time) == pytest.approx(1e-4 * spacing, rel=1e-2)


def test_what_jitters_is_not_taken_for_rounded_and_even_rows_stay_as_they_are() -> None:
    rng, even = np.random.default_rng(0), 2.5e-3 * np.arange(500, dtype=np.float64)
    jitter = np.round(even + 6e-4 * rng.uniform(-1.0, 1.0, even.size), 3).astype(np.float64)
    assert unrounded(jitter) is None
    assert unrounded(even + 6e-4 * rng.uniform(-1.0, 1.0, even.size)) is None
    assert unrounded(even) is None
    lost = np.delete(np.round(even, 3), 200)
    assert unrounded(lost) is None


@pytest.mark.parametrize("kept", [lambda k: k != 1500, lambda k: k % 10 != 3, lambda k: k % 3 > 0])
def test_lost_rows_of_a_clock_as_long_as_a_row_stay_lost(kept: Callable[[int], bool]) -> None:
    time = np.array([1e-3 * k for k in range(3000) if kept(k)])
    assert unrounded(np.round(time, 3)) is None


def test_a_few_rows_written_by_hand_stay_where_they_are() -> None:
    for times in ([0.0, 1.0, 3.0], [0.0, 2.0, 5.0, 7.0], [0.0, 0.2, 0.5, 0.7, 1.0]):
        assert unrounded(np.array(times)) is None
