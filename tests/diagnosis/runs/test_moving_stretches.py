"""Of long recordings what moves is compared, and what was taken is said."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gmfbo import Recording
from gmfbo.diagnosis.runs.moving_stretches import MOST_STEPS, STRETCH, moving_stretches

STEP = 1e-2
LIMIT = MOST_STEPS * STEP
LENGTH = STRETCH * STEP


def logged(
    column: NDArray[np.float64], name: str = "log.csv", gains: Mapping[str, float] | None = None
) -> Recording:
    time = 0.1 * np.arange(column.size, dtype=np.float64)
    noise = 1e-3 * np.random.default_rng(column.size).standard_normal(column.size)
    signals = {"position": column + noise, "reference": column}
    return Recording(time=time, signals=signals, name=name, parameters=gains or {})


def moving(seconds: float, start: float, end: float) -> NDArray[np.float64]:
    """At rest but between two times."""
    t = np.arange(round(seconds / 0.1)) * 0.1
    return np.where((t > start) & (t < end), np.sin(0.5 * (t - start)), 0.0)


def test_what_is_short_is_compared_whole() -> None:
    one = logged(moving(LIMIT / 2, 0.0, 100.0))
    told = moving_stretches([one, one], ["position"], STEP)
    assert told.recordings == (one, one)
    assert not told.notes


@settings(deadline=None, max_examples=15)
@given(
    lengths=st.lists(st.floats(20.0, 4.0 * LIMIT), min_size=1, max_size=5),
    seed=st.integers(0, 10),
)
def test_stretches_are_of_the_recordings_apart_and_within_the_limit(
    lengths: list[float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    given_ones = [
        logged(np.cumsum(rng.standard_normal(round(seconds / 0.1))), f"log{k}.csv")
        for k, seconds in enumerate(lengths)
    ]
    told = moving_stretches(given_ones, ["position"], STEP)
    by_name = {one.name: one for one in given_ones}
    assert sum(one.duration for one in told.recordings) <= LIMIT * (1.0 + 1e-9)
    assert told.recordings
    for name, whole in by_name.items():
        taken = [t for t in told.recordings if t.name.split(" [")[0] == name]
        rows = np.concatenate([one.time for one in taken]) if taken else np.zeros(0)
        assert np.all(np.diff(rows) > 0.0)
        assert np.isin(rows, whole.time).all()
        for one in taken:
            first = int(np.searchsorted(whole.time, one.time[0]))
            np.testing.assert_array_equal(
                one.signal("position"), whole.signal("position")[first : first + len(one)]
            )
            assert one.duration < 2.3 * LENGTH


def test_rest_is_left_out() -> None:
    begin, end = 2.0 * LIMIT, 3.5 * LIMIT
    told = moving_stretches([logged(moving(5.0 * LIMIT, begin, end))], ["position"], STEP)
    rows = np.concatenate([one.time for one in told.recordings])
    inside = (rows > begin) & (rows < end)
    assert inside.sum() * 0.1 > 0.7 * LIMIT


def test_what_moves_in_another_way_is_taken_though_it_is_rare() -> None:
    """One stretch of fast motion among a slow sweep that goes on for hours."""
    t = np.arange(round(6.0 * LIMIT / 0.1)) * 0.1
    column = np.sin(0.02 * t)
    rare = (t > 3.3 * LIMIT) & (t < 3.3 * LIMIT + LENGTH)
    column[rare] += 0.3 * np.sin(2.0 * (t[rare] - 3.3 * LIMIT))
    told = moving_stretches([logged(column)], ["position"], STEP)
    rows = np.concatenate([one.time for one in told.recordings])
    taken = (rows > 3.3 * LIMIT) & (rows < 3.3 * LIMIT + LENGTH)
    assert np.count_nonzero(taken) * 0.1 > 0.9 * LENGTH


def test_each_set_of_gains_is_heard() -> None:
    """Nine tenths of the time has one, and moves more."""
    loud = logged(3.0 * moving(9.0 * LIMIT, 0.0, 9.0 * LIMIT), "loud.csv", {"kp": 1.0})
    calm = logged(moving(LIMIT, 0.0, LIMIT), "calm.csv", {"kp": 2.0})
    told = moving_stretches([loud, calm], ["position"], STEP)
    assert {one.name.split(" [")[0] for one in told.recordings} == {"loud.csv", "calm.csv"}


def test_a_stretch_is_named_by_its_times() -> None:
    told = moving_stretches([logged(moving(5.0 * LIMIT, 1300.0, 1400.0))], ["position"], STEP)
    for one in told.recordings:
        first, last = one.name.removeprefix("log.csv [").removesuffix("] s").split(", ")
        assert float(first) == pytest.approx(one.time[0], abs=0.6)
        assert float(last) == pytest.approx(one.time[-1], abs=0.6)
        assert one.name in told.notes[0]


def test_it_is_cut_where_the_axis_rests() -> None:
    t = np.arange(round(3.0 * LIMIT / 0.1)) * 0.1
    cycle = t % (0.4 * LENGTH) / (0.4 * LENGTH)
    column = np.where(cycle < 0.75, np.sin(2.0 * np.pi * 4.0 * cycle), 0.0)
    told = moving_stretches([logged(column)], ["position"], STEP)
    for one in told.recordings:
        for edge in (one.time[0], one.time[-1]):
            place = edge % (0.4 * LENGTH) / (0.4 * LENGTH)
            assert place > 0.7 or place < 0.05 or edge in (t[0], t[-1])


def test_a_column_that_a_recording_lacks_or_that_has_gaps_is_no_hindrance() -> None:
    whole = logged(moving(3.0 * LIMIT, 0.5 * LIMIT, 1.5 * LIMIT))
    holes = whole.signal("position").copy()
    holes[::3] = np.nan
    lacking = Recording(
        time=whole.time, signals={"position": holes, "torque": np.ones(len(whole))}, name="b.csv"
    )
    told = moving_stretches([whole, lacking], ["position", "torque", "speed"], STEP)
    assert sum(one.duration for one in told.recordings) > 0.8 * LIMIT


def test_rows_that_come_faster_than_the_twin_steps_count_too() -> None:
    time = 1e-5 * np.arange(4_000_000, dtype=np.float64)
    fast = Recording(time=time, signals={"position": np.sin(time)}, name="scope.csv")
    told = moving_stretches([fast], ["position"], 1e-3)
    assert sum(len(one) for one in told.recordings) <= 10 * MOST_STEPS
