"""Recordings become even columns; what a logger lost or rounded is found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.scored_record import Record, scored_record
from gmfbo.diagnosis.scoring.windows import windows_of
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from tests.diagnosis.short_recordings import SERVO

STEP = 1e-3
SIGNALS = ("position", "torque_command")
ROWS = 500


@pytest.fixture(scope="module")
def servo() -> Iterator[AugmentedTwin]:
    with AugmentedTwin(SERVO.twin(), isolated=False) as simulator:
        yield simulator


def ramp(time: NDArray[np.float64]) -> NDArray[np.float64]:
    return 2.0 * time


def recording_at(
    time: NDArray[np.float64],
    use: tuple[float, float] | None = None,
    **columns: NDArray[np.float64],
) -> Recording:
    signals: Mapping[str, NDArray[np.float64]] = {
        "reference": ramp(time),
        "position": ramp(time),
        "torque_command": np.cos(time),
        **columns,
    }
    return Recording(time=time, signals=signals, name="a.csv", parameters={"kp": 40.0}, use=use)


def scored(servo: AugmentedTwin, recording: Recording, warmup: float = 0.0) -> Record:
    return scored_record(recording, servo.plan(recording, {}), SIGNALS, warmup)


def clock(rows: int = ROWS) -> NDArray[np.float64]:
    return np.arange(rows, dtype=np.float64) * STEP


def test_even_columns_are_taken_as_they_are(servo: AugmentedTwin) -> None:
    recording = recording_at(clock())
    position = scored(servo, recording).signals[0]
    np.testing.assert_array_equal(position.values, recording.signals["position"])
    np.testing.assert_array_equal(position.time, recording.time)
    assert position.spacing == pytest.approx(STEP)


def test_jitter_below_a_seventh_of_a_sample_counts_as_even(servo: AugmentedTwin) -> None:
    jitter = np.random.default_rng(0).uniform(-0.1, 0.1, ROWS) * STEP
    jitter[[0, -1]] = 0.0
    recording = recording_at(clock() + jitter)
    np.testing.assert_array_equal(
        scored(servo, recording).signals[0].values, recording.signals["position"]
    )


def test_coarser_jitter_is_put_on_even_times(servo: AugmentedTwin) -> None:
    jitter = np.random.default_rng(0).uniform(-0.3, 0.3, ROWS) * STEP
    jitter[[0, -1]] = 0.0
    position = scored(servo, recording_at(clock() + jitter)).signals[0]
    np.testing.assert_allclose(np.diff(position.time), position.spacing, rtol=1e-6)
    np.testing.assert_allclose(position.values, ramp(position.time), atol=1e-12)


def test_dropped_rows_are_filled_along_the_line_beside_them(servo: AugmentedTwin) -> None:
    time = np.delete(clock(), [100, 101, 300])
    record = scored(servo, recording_at(time))
    assert record.gaps == ()
    np.testing.assert_allclose(record.signals[0].time, clock(), atol=1e-12)
    np.testing.assert_allclose(record.signals[0].values, ramp(clock()), atol=1e-12)


def test_time_stamps_rounded_by_the_logger_add_no_rows(servo: AugmentedTwin) -> None:
    time = np.round(np.arange(400) * 1.37e-3, 4)
    position = scored(servo, recording_at(time)).signals[0]
    assert position.values.size == 400
    assert position.spacing == pytest.approx(1.37e-3, rel=1e-3)


def test_blank_cells_make_a_slower_signal_and_no_gap(servo: AugmentedTwin) -> None:
    position = ramp(clock())
    position[np.arange(ROWS) % 4 != 0] = np.nan
    record = scored(servo, recording_at(clock(), position=position))
    slow, fast = record.signals
    assert [slow.spacing, fast.spacing] == pytest.approx([4 * STEP, STEP])
    np.testing.assert_allclose(slow.values, ramp(slow.time), atol=1e-12)
    assert record.gaps == ()


def test_a_gap_of_many_rows_is_not_scored_by_a_line_across_it(servo: AugmentedTwin) -> None:
    position = np.sin(20.0 * clock())
    position[200:230] = np.nan
    record = scored(servo, recording_at(clock(), position=position))
    (gap,) = record.gaps
    assert [gap.start, gap.end] == pytest.approx([0.199, 0.23])
    assert not gap.of_input
    windows = windows_of([record], loop_time=0.01)
    rows = np.concatenate([np.arange(w.rows[0].start, w.rows[0].stop) for w in windows])
    lost = np.arange(200, 230)
    assert not np.intersect1d(rows, lost).size
    assert rows.size > ROWS - 2 * lost.size


def test_after_a_gap_of_the_reference_the_axis_settles_before_it_is_scored(
    servo: AugmentedTwin,
) -> None:
    reference = ramp(clock())
    reference[200:230] = np.nan
    record = scored(servo, recording_at(clock(), reference=reference))
    windows = windows_of([record], loop_time=0.01)
    assert [w.rows[0].start for w in windows] == [0, pytest.approx(330, abs=1)]


def test_gaps_that_leave_no_stretch_are_refused(servo: AugmentedTwin) -> None:
    position = ramp(clock())
    position[np.arange(ROWS) % 50 < 10] = np.nan
    record = scored(servo, recording_at(clock(), position=position))
    with pytest.raises(RecordingError, match="record longer, or without gaps"):
        windows_of([record], loop_time=0.01)


def test_warm_up_and_use_bound_what_is_scored(servo: AugmentedTwin) -> None:
    record = scored(servo, recording_at(clock(), use=(0.05, 0.4)), warmup=0.1)
    assert [record.start, record.end] == pytest.approx([0.1, 0.4])
    assert record.signals[0].values[0] == pytest.approx(ramp(np.array([0.1]))[0])


def test_signals_are_cut_to_the_time_that_all_of_them_share(servo: AugmentedTwin) -> None:
    late, early = np.cos(clock()), ramp(clock())
    late[:60], early[450:] = np.nan, np.nan
    record = scored(servo, recording_at(clock(), torque_command=late, position=early))
    for signal in record.signals:
        assert signal.time[0] == pytest.approx(0.06)
        assert signal.time[-1] == pytest.approx(0.449)


def test_a_signal_with_few_rows_is_left_out(servo: AugmentedTwin) -> None:
    blank = np.full(ROWS, np.nan)
    blank[:63] = 1.0
    record = scored(servo, recording_at(clock(), torque_command=blank))
    assert [s.name for s in record.signals] == ["position"]


def test_a_recording_of_fewer_than_64_rows_is_refused_in_one_line(servo: AugmentedTwin) -> None:
    with pytest.raises(RecordingError, match=r"^a\.csv: expected at least 64 rows .*") as error:
        scored(servo, recording_at(clock(63)))
    assert "\n" not in str(error.value)
