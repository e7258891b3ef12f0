"""Faults of logging are told from a column alone, and a sound column is left in peace."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo.diagnosis.checking.column_quality import (
    _chance_of_repeat,
    clipped_rows,
    clock_quality,
    is_latched,
    lost_rows,
    near_rounding,
    refresh_rows,
    repeated_rows,
    usual_noise,
)
from gmfbo.diagnosis.runs.quantum import resolution

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


def counted(true: NDArray[np.float64], digits: int) -> NDArray[np.float64]:
    """Encoder of 2^20 counts a turn, whose readings are written with so many digits."""
    count = 2.0 * np.pi / 2**20
    noisy = true + 0.8 * count * np.random.default_rng(2).standard_normal(true.size)
    return np.array([float(f"{one:.{digits}g}") for one in np.round(noisy / count) * count])


@pytest.mark.parametrize("digits", [7, 8, 9])
@pytest.mark.parametrize("height", [0.3, 3.0, 30.0])
def test_counts_that_are_written_with_few_digits_repeat_by_rounding(
    digits: int, height: float
) -> None:
    time = 1e-3 * np.arange(6000)
    rest_and_ramps = height + 0.2 * np.interp(
        time, [0, 1, 2, 3, 4, 4.2, 6], [0, 0, 1, 1, 0, 0, 2e-3]
    )
    column = counted(rest_and_ramps, digits)
    assert repeated_rows(column, resolution(column)).size == 0
    # Negative control: readings that are repeated while the axis moves fast.
    planted = set(range(1100, 1900, 40))
    for row in sorted(planted):
        column[row] = column[row - 1]
    found = set(repeated_rows(column, resolution(column)).tolist())
    assert planted <= found
    assert len(found) <= len(planted) + 2  # rows beside a rest are seen as moving


def speed_loop() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coarse speed that rests and then runs, and the current of 11 A s/rad computed from it."""
    rng = np.random.default_rng(4)
    asked = 317.3 * np.clip(TIME - 1.0, 0.0, 1.0)
    true = asked * (1.0 + 0.02 * np.sin(40.0 * TIME))
    speed = 0.03 * np.round((true + 0.04 * rng.standard_normal(TIME.size)) / 0.03)
    drift = 0.8 * np.sin(3.0 * TIME)
    return speed, 0.01 * np.round((11.0 * (asked - speed) + drift) / 0.01)


def test_what_is_computed_from_a_coarse_reading_repeats_where_that_does() -> None:
    speed, current = speed_loop()
    quantum = resolution(current)
    near = near_rounding(TIME, TIME, speed, resolution(speed))
    assert repeated_rows(current, quantum).size > 50
    assert repeated_rows(current, quantum, near).size == 0
    # Negative control: the logger misses samples while the speed rises.
    rows = list(range(1100, 1300, 10))
    for row in rows:
        current[row] = current[row - 1]
    assert not near[rows].any()
    assert set(rows) <= set(repeated_rows(current, quantum, near).tolist())
    # Negative control: a fast and fine reading repeats nowhere.
    assert not near_rounding(TIME, TIME, np.cumsum(1.0 + TIME), 1e-3).any()


def of_counts(seed: int) -> NDArray[np.float64]:
    """Command of a noisy encoder's error and of its rate over two rows, as a converter holds it."""
    counts = np.round(2.0 * np.random.default_rng(seed).standard_normal(2500))
    rate = counts - np.roll(counts, 2)
    return np.asarray(5e-3 * np.round((22.5e-3 * rate + 1e-3 * counts) / 5e-3))


def chance_held(rows: int, seed: int) -> NDArray[np.float64]:
    """Readings of which one in two is that of the row before, without any order in it."""
    rng = np.random.default_rng(seed)
    column = np.cumsum(rng.standard_normal(rows))
    for row in range(1, rows):
        if rng.random() < 0.5:
            column[row] = column[row - 1]
    return column


def test_a_command_of_few_values_repeats_by_chance() -> None:
    alike = []
    for seed in range(30):
        command = of_counts(seed)
        alike.append(np.count_nonzero(np.diff(command) == 0.0))
        assert repeated_rows(command, resolution(command)).size == 0
    # An oracle: by resolution and noise alone, chance makes a third of these rows at most.
    sigma = float(np.std(of_counts(0)))
    assert np.mean(alike) > 3.0 * 2500 * 5e-3 / (2.0 * np.sqrt(np.pi) * sigma)
    # Negative control: a logger that misses one sample in ten.
    command = of_counts(0)
    for row in range(10, 2490, 10):
        command[row] = command[row - 1]
    assert repeated_rows(command, resolution(command)).size > 240


@settings(max_examples=30, deadline=None)
@given(st.floats(2.0, 20.0), st.integers(0, 99))
def test_rounded_noise_repeats_as_often_as_chance_tells(noise: float, seed: int) -> None:
    """Noise of so many quanta; a false alarm in ten thousand is what four sigma leave."""
    rng = np.random.default_rng(seed)
    column = np.round(noise * rng.standard_normal(3000))
    steps = np.diff(column)
    expected = 2999 / (2.0 * np.sqrt(np.pi) * noise)
    told = float(np.sum(_chance_of_repeat(steps, 1.0)))
    assert np.count_nonzero(steps == 0.0) == pytest.approx(expected, abs=5.0 * np.sqrt(expected))
    assert told == pytest.approx(expected, rel=0.25)
    assert repeated_rows(column, 1.0).size == 0


def test_slow_motion_on_coarse_counts_is_no_latch() -> None:
    """No logger holds each value for 1.9 rows and logs some for one row only."""
    column = chance_held(3000, 1)
    lengths = np.diff(np.flatnonzero(np.diff(column)))
    assert float(np.mean(lengths)) > 1.8
    assert not is_latched(refresh_rows(column, 0.0))
    # Negative control: a logger that is slower by half, and one by 2.5.
    for rows in (2.0, 2.5):
        held = motion()[np.floor(np.arange(2000) / rows).astype(int)]
        assert is_latched(refresh_rows(held, 0.0))


def test_an_axis_that_sticks_where_it_turns_is_at_no_limit() -> None:
    """Counts of a real axis at the top of an overshoot, between set points."""
    top = [700, 1400, 1900, 2131, 2154, 2161, 2159, 2162, 2167, 2170, 2170, 2170, 2170]
    way = np.array([*range(0, 700, 90), *top, *[2169, 2169, 2168, 2167, 2165, 2160] * 3], float)
    assert clipped_rows(way, 1.0) == 4
    assert clipped_rows(way, 1.0, is_position=True) == 0
    # Negative control: an end stop at that place, run into at full speed.
    stopped = np.minimum(np.cumsum(90.0 + 5.0 * np.sin(np.arange(60.0))), 2170.0)
    assert clipped_rows(stopped, 1.0, is_position=True) > 20


def test_a_command_that_repeats_while_its_reading_moves_on_is_told() -> None:
    """A short recording: the axis rests at both ends, where the command rightly repeats."""
    time = np.arange(150, dtype=np.float64) * 20e-3
    asked = 13.0 * np.clip(np.minimum(time - 0.3, 2.4 - time), 0.0, 0.9)
    true = asked * (1.0 + 0.05 * np.sin(3.0 * time))
    read = np.asarray(2.2e-3 * np.round(true / 2.2e-3), dtype=np.float64)
    command = 2.4 * (asked - read) + 1e-3 * asked**2
    near = near_rounding(time, time, read, resolution(read))
    assert repeated_rows(command, resolution(command), near).size == 0
    # Negative control: the logger misses samples on the way up and down.
    rows = [25, 29, 33, 36, 40, 42, 90, 95, 99, 103]
    for row in rows:
        command[row] = command[row - 1]
    assert set(rows) <= set(repeated_rows(command, resolution(command), near).tolist())


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


@pytest.mark.parametrize("time_constant", [1e-3, 3e-3])
def test_an_axis_that_starts_and_stops_within_a_row_loses_none(time_constant: float) -> None:
    """Rows of 10 ms of a move at a speed that sets in and ends faster than that."""
    fine = 1e-4 * np.arange(30_000)
    asked = np.where((fine > 0.5) & (fine < 1.3), 1000.0, 0.0) - np.where(fine > 2.0, 400.0, 0.0)
    speed, own = np.zeros(fine.size), 0.0
    for row, wanted in enumerate(asked):
        own += 1e-4 / time_constant * (wanted - own)
        speed[row] = own
    for start in range(0, 100, 10):
        position = (1e-4 * np.cumsum(speed))[start::100]
        reference = np.where(fine > 0.5, 800.0, 0.0)[start::100]
        assert lost_rows([position], [reference]).size == 0
        # Negative control: a row that is lost at that speed.
        kept = np.arange(position.size) != 90
        assert lost_rows([position[kept]], [reference[kept]]).tolist() == [90]


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


@settings(max_examples=30, deadline=None)
@given(st.floats(0.02, 2.0), st.integers(0, 99))
def test_steps_of_the_reference_are_no_noise_of_a_command(noise: float, seed: int) -> None:
    """A command jumps with the set point each half second, and settles within 20 ms."""
    kicks = 8.0 * np.exp(-(np.arange(2000) % 500) / 20.0)
    white = noise * np.random.default_rng(seed).standard_normal(2000)
    assert usual_noise(kicks + white) == pytest.approx(noise, rel=0.2)
    # Negative control: the same noise without a set point, and none at all.
    assert usual_noise(white) == pytest.approx(noise, rel=0.2)
    assert usual_noise(np.zeros(2000)) == 0.0


def test_an_axis_at_rest_for_most_of_the_time_tells_its_noise_where_it_moves() -> None:
    column = np.where(TIME < 1.2, 0.0, motion(noise=1e-3))
    assert usual_noise(column) == pytest.approx(1e-3, rel=0.3)
