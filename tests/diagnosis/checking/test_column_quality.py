"""Faults of logging are told from a column alone, and a sound column is left in peace."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.checking.column_quality import (
    clipped_rows,
    clock_quality,
    is_latched,
    lost_rows,
    refresh_rows,
    repeated_rows,
)
from gmfbo.diagnosis.runs.scored_record import resolution

TIME = np.arange(2000, dtype=np.float64) * 1e-3
NOWHERE = np.array([], dtype=np.int64)


def motion(seed: int = 0, noise: float = 1e-4) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    wave = 0.4 * np.sin(2.0 * np.pi * 1.3 * TIME) + 0.1 * np.sin(2.0 * np.pi * 4.1 * TIME + 1.0)
    return np.asarray(wave + noise * rng.standard_normal(TIME.size))


@settings(max_examples=30, deadline=None)
@given(st.sets(st.integers(20, 1980), min_size=1, max_size=40), st.integers(0, 9))
def test_exactly_the_rows_that_were_repeated_are_found(rows: set[int], seed: int) -> None:
    column = motion(seed)
    for row in sorted(rows):
        column[row] = column[row - 1]
    inner = (column < column.max()) & (column > column.min())
    planted = [row for row in sorted(rows) if inner[row]]
    assert repeated_rows(column, 0.0).tolist() == planted


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-5, 1e-2), st.integers(0, 9), st.sampled_from([0.0, 1e-4]))
def test_a_sound_column_shows_no_fault_at_any_resolution(
    quantum: float, seed: int, noise: float
) -> None:
    column = np.round(motion(seed, noise) / quantum) * quantum
    own = resolution(column)
    assert repeated_rows(column, own).size == 0
    assert clipped_rows(column, own) == 0
    assert not is_latched(refresh_rows(column, own))
    assert lost_rows([column], []).size == 0


@pytest.mark.parametrize("factor", [2, 4, 10])
def test_a_column_at_a_lower_rate_is_told_with_its_rate(factor: int) -> None:
    column = np.repeat(motion()[::factor], factor)
    assert refresh_rows(column, 0.0) == pytest.approx(factor)
    assert is_latched(refresh_rows(column, 0.0))


def test_rest_is_neither_a_latch_nor_a_repeat_nor_a_limit() -> None:
    column = np.where(TIME < 0.5, 0.0, 1.0 - np.exp(-(TIME - 0.5) / 0.05))
    column[TIME > 1.5] = column[TIME > 1.5][0]
    assert not is_latched(refresh_rows(column, 0.0))
    assert repeated_rows(column, 0.0).size == 0
    assert clipped_rows(column, 0.0) == 0


def test_a_dither_by_one_count_at_rest_is_no_latch() -> None:
    moving = np.tile(np.arange(0.0, 200.0, 10.0), 2)
    rest = 190.0 + np.tile([0.0] * 20 + [1.0], 3)
    assert not is_latched(refresh_rows(np.concatenate([moving, rest, moving, rest]), 1.0))


@pytest.mark.parametrize("rows", [2, 4])
def test_an_axis_that_sticks_repeats_no_reading(rows: int) -> None:
    steps = 1e-3 * np.abs(np.sin(2.0 * np.pi * 3.0 * TIME))
    for turn in range(250, 1900, 166):
        steps[turn : turn + rows] = 0.0
        steps[turn + rows : turn + rows + 4] *= [0.1, 0.3, 0.6, 0.9]
    assert repeated_rows(np.cumsum(steps), 0.0).size == 0
    # Negative control: a reading that is repeated while the axis goes on.
    column = np.cumsum(np.full(TIME.size, 1e-3) + 2e-4 * np.sin(2.0 * np.pi * 3.0 * TIME))
    column[700 : 700 + rows] = column[699]
    assert repeated_rows(column, 0.0).tolist() == list(range(700, 700 + rows))


def test_a_value_at_steady_speed_is_no_limit() -> None:
    speed = np.clip(np.cumsum(np.where(np.arange(2000) % 1000 < 500, 1.0, -1.0)), -200.0, 200.0)
    friction = 0.4 * np.sign(speed) + 1e-3 * speed
    assert clipped_rows(friction, 0.0) > 200
    assert clipped_rows(friction, 0.0, speed) == 0
    # Negative control: at a limit of the command the axis goes on to accelerate.
    limited = np.clip(friction, -0.45, 0.45)
    accelerating = np.cumsum(np.cumsum(limited))
    assert clipped_rows(limited, 0.0, accelerating) == clipped_rows(limited, 0.0) > 200


def test_rows_at_a_limit_are_counted() -> None:
    column = motion()
    clipped = np.clip(column, -0.35, 0.35)
    assert clipped_rows(clipped, 0.0) == pytest.approx(np.sum(np.abs(column) > 0.35), rel=0.02)
    assert clipped_rows(column, 0.0) == 0


@pytest.mark.parametrize("count", [1, 3])
def test_rows_lost_without_a_trace_in_the_clock_are_found(count: int) -> None:
    reference, measured = motion(noise=0.0), motion(noise=2e-5)
    kept = np.ones(TIME.size, dtype=bool)
    kept[900 : 900 + count] = False
    assert lost_rows([measured[kept]], [reference[kept]]).tolist() == [900]


def test_a_jump_that_the_reference_does_not_share_is_no_lost_row() -> None:
    reference, measured = motion(noise=0.0), motion(noise=0.0)
    measured[900:] += 3.0 * (measured[900] - measured[899])
    assert lost_rows([measured], [reference]).size == 0
    assert lost_rows([measured], []).tolist() == [900]


def test_rows_that_the_clock_leaves_out_are_counted_and_are_no_jitter() -> None:
    kept = np.ones(TIME.size, dtype=bool)
    kept[[300, 301, 700]] = False
    quality = clock_quality(TIME[kept], np.array([300], dtype=np.int64))
    assert quality.lost_by_clock == 3
    assert quality.jitter < 1e-9
    assert quality.lost_at == ()  # it is in the times


def test_jitter_is_the_largest_deviation_of_a_step() -> None:
    time = TIME.copy()
    time[500] += 0.08e-3
    quality = clock_quality(time, NOWHERE)
    assert quality.jitter == pytest.approx(0.08)
    assert quality.step == pytest.approx(1e-3)
    assert quality.lost_by_clock == 0
