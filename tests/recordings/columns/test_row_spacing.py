"""Rows that lie as far apart as only another unit of time explains are refused with that unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.recording import Recording, read_recording
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.twin_words import TwinWords

STEP = 1e-3


@dataclass(frozen=True)
class Stepped(TwinWords):
    """Words of a twin with a communication step [s]."""

    step: float = STEP


TWIN = Stepped((SignalSpec("u", "u"), SignalSpec("y", "y", compared=True)))


def log(folder: Path, clock: str, spacing: float, rows: int = 100, signal: str = "y") -> Path:
    path = folder / "log.csv"
    lines = [f"{clock},{signal}", *(f"{spacing * k!r},{0.1 * k:g}" for k in range(rows))]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("clock", "spacing", "apart", "likely"),
    [
        ("t", 1e6, "rows 1,000,000 s apart, 1,000,000,000 steps", "ns"),
        ("time [s]", 2.0, "rows 2 s apart, 2,000 steps", "ms"),
        ("time [us]", 1e6, "rows 1 s apart, 1,000 steps", "ns"),
        ("time [ms]", 250.0, "rows 0.25 s apart, 250 steps", "us"),
    ],
)
def test_the_likely_unit_is_told(
    clock: str, spacing: float, apart: str, likely: str, tmp_path: Path
) -> None:
    name = clock.split()[0]
    told = f'{apart} of the twin each; is the time in {likely}? write time = {{ column = "{name}"'
    with pytest.raises(RecordingError) as refused:
        read_recording(log(tmp_path, clock, spacing), TWIN)
    assert told in str(refused.value)


def test_seconds_that_are_called_milliseconds_are_told(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"100 rows in 0\.099 steps of the twin; .* in s\?"):
        read_recording(log(tmp_path, "time [ms]", 1e-3), TWIN)


@pytest.mark.parametrize(("unit", "seconds"), [("min", 60.0), ("h", 3600.0), ("d", 86400.0)])
def test_few_steps_in_seconds_and_a_round_distance_in_a_longer_unit_are_told(
    unit: str, seconds: float, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=rf"400 rows in .* steps of the twin; .* in {unit}\?"):
        read_recording(log(tmp_path, "t", 1e-3 / seconds, 400), TWIN)


def test_many_rows_within_one_step_show_nothing(tmp_path: Path) -> None:
    told = r"401 rows in 0\.8 steps of the twin; is the time in another unit\?"
    with pytest.raises(RecordingError, match=told):
        read_recording(log(tmp_path, "t", 2e-6, 401), TWIN)


@pytest.mark.parametrize("spacing", [3e-6, 1e-5])
def test_a_short_shot_of_an_oscilloscope_is_read(spacing: float, tmp_path: Path) -> None:
    """Negative control: it is short too, and its distance of rows is round in seconds."""
    assert len(read_recording(log(tmp_path, "t", spacing, 400), TWIN)) == 400


@pytest.mark.parametrize("spacing", [1e-5, 1e-4, 1e-3, 1e-2, 0.1])
def test_fast_and_slow_loggers_are_read(spacing: float, tmp_path: Path) -> None:
    """From a hundred rows a step to a hundred steps a row."""
    rows = 2000 if spacing < STEP else 100
    assert len(read_recording(log(tmp_path, "t", spacing, rows), TWIN)) == rows


def test_the_twin_file_has_the_last_word(tmp_path: Path) -> None:
    hourly = log(tmp_path, "t", 3600.0)
    stated = ColumnMapping({"time": MappedColumn("t", unit="s")})
    assert read_recording(hourly, TWIN, mapping=stated).time[1] == 3600.0
    named = ColumnMapping({"time": MappedColumn("t")})
    with pytest.raises(RecordingError, match="3,600,000 steps of the twin each"):
        read_recording(hourly, TWIN, mapping=named)


def test_set_points_may_lie_far_apart(tmp_path: Path) -> None:
    assert len(read_recording(log(tmp_path, "t", 60.0, signal="u"), TWIN)) == 100


def test_files_of_gmfbo_are_in_seconds(tmp_path: Path) -> None:
    slow = Recording(time=np.arange(100.0), signals={"y": np.arange(100.0)})
    write_recording(slow, tmp_path / "own.csv")
    assert len(read_recording(tmp_path / "own.csv", TWIN)) == 100


@dataclass(frozen=True)
class Resampled(Stepped):
    """Words of a twin whose file has recordings put on an even clock [s]."""

    resample: float | None = STEP


def test_resampling_does_not_hide_a_clock_in_ms(tmp_path: Path) -> None:
    words = Resampled((SignalSpec("u", "u"), SignalSpec("y", "y", compared=True)))
    with pytest.raises(RecordingError, match=r"rows 1 s apart, .* is the time in ms\?"):
        read_recording(log(tmp_path, "t", 1.0), words)


def test_rows_of_one_instant_are_judged_as_one(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{k},{0.1 * k:g}\n{k},\n{k}," for k in range(100)]
    path.write_text("t,y\n" + "\n".join(rows) + "\n")
    with pytest.raises(RecordingError, match=r"rows 1 s apart, .* is the time in ms\?"):
        read_recording(path, TWIN)


def test_a_stated_sample_time_is_a_stated_clock(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("a,y\n" + "\n".join(f"0,{0.1 * k:g}" for k in range(100)) + "\n")
    mapping = ColumnMapping({"time": MappedColumn("", sample_time=1.0)})
    assert read_recording(path, TWIN, mapping=mapping).duration == pytest.approx(99.0)
