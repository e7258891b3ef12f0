"""A unit at the end of a column's name is read where it is one of the signal's quantity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.columns.unit_in_name import names_and_units, note_on_header
from gmfbo.recordings.recording import Recording, read_recording
from tests.recordings.twin_words import TwinWords

TWIN = TwinWords(
    (
        SignalSpec("angle", "angle", unit="rad"),
        SignalSpec("speed", "speed", unit="rad/s"),
        SignalSpec("way", "way", unit="m"),
        SignalSpec("bare", "bare"),
        SignalSpec("counted", "counted", scale=0.25, scaled=True, unit="rad"),
    )
)


def read(
    folder: Path, header: str, row: str = "1,2", mapping: ColumnMapping | None = None
) -> Recording:
    path = folder / "log.csv"
    path.write_text(f"{header}\n0,0\n{row}\n")
    return read_recording(path, TWIN, mapping=mapping)


@pytest.mark.parametrize(
    ("column", "signal", "value"),
    [
        ("angle_deg", "angle", np.pi / 90),
        ("angle/deg", "angle", np.pi / 90),
        ("angle(Deg)", "angle", np.pi / 90),
        ("angle in deg", "angle", np.pi / 90),
        ("angle {deg}", "angle", np.pi / 90),
        ("angle - deg", "angle", np.pi / 90),
        ('"angle, deg"', "angle", np.pi / 90),
        ("angle_rev", "angle", 4 * np.pi),
        ("speed_rpm", "speed", np.pi / 15),
        ("speed_rad_s", "speed", 2.0),
        ("speed_deg_per_s", "speed", np.pi / 90),
        ("speed/(deg/s)", "speed", np.pi / 90),
        ("way_mm", "way", 2e-3),
        ("bare_mm", "bare", 2e-3),
        ("counted_deg", "counted", 0.5),
    ],
)
def test_the_unit_counts(column: str, signal: str, value: float, tmp_path: Path) -> None:
    recording = read(tmp_path, f"time_ms,{column}")
    assert recording.time[1] == 1e-3
    assert recording.signal(signal)[1] == pytest.approx(value)
    if signal != "counted":
        column = column.strip('"')
        assert f"{column} as {signal} [" in recording.notes[0]


@pytest.mark.parametrize(
    "column",
    [
        "way_in",
        "angle_r",
        "angle_m",
        "speed_s",
        "angle_max",
        "angle_Nm",
        "angle_counts",
        "angle - raw",
    ],
)
def test_other_words_are_no_units(column: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="got none of them"):
        read(tmp_path, f"t,{column}")


def test_a_plain_name_comes_first(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,time_ms,angle,angle_deg\n0,0,0,0\n1,9,2,7\n")
    recording = read_recording(path, TWIN)
    assert recording.time[1] == 1.0
    assert recording.signal("angle")[1] == 2.0
    assert recording.notes == ()


def test_two_columns_of_one_signal_are_not_chosen_from(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,bare,angle_rad,angle_deg\n0,0,0,0\n1,9,2,7\n")
    assert "angle" not in read_recording(path, TWIN).signals


def test_the_twin_files_unit_comes_before_the_name(tmp_path: Path) -> None:
    stated = ColumnMapping({"angle": MappedColumn("angle_deg", unit="rad")})
    assert read(tmp_path, "t,angle_deg", mapping=stated).signal("angle")[1] == 2.0
    named = ColumnMapping({"angle": MappedColumn("angle_deg")})
    recording = read(tmp_path, "t,angle_deg", mapping=named)
    assert recording.signal("angle")[1] == pytest.approx(np.pi / 90)


def test_a_header_that_contradicts_the_twin_file_is_told(tmp_path: Path) -> None:
    stated = ColumnMapping({"angle": MappedColumn("Ist", unit="deg")})
    recording = read(tmp_path, "t,Ist [rad]", mapping=stated)
    assert recording.signal("angle")[1] == pytest.approx(np.pi / 90)
    (note,) = recording.notes
    assert note.startswith("log.csv: the header of Ist says [rad], [columns] of the twin file says")
    assert note_on_header(recording.notes, "angle") == note
    assert note_on_header(recording.notes, "speed") == ""
    assert read(tmp_path, "t,Ist [°]", mapping=stated).notes == ()


def test_a_clock_is_read_without_a_twin(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("Timestamp_us,delay [s]\n0,5\n1000,6\n")
    np.testing.assert_allclose(read_recording(path).time, [0.0, 1e-3])


def test_an_absurd_name_takes_no_time() -> None:
    assert list(names_and_units("time" + 200_000 * " " + "in  ms")) == []


def test_a_group_is_no_unit() -> None:
    assert list(names_and_units("drive/iq")) == []
    assert list(names_and_units("group 0/position")) == []


@pytest.mark.parametrize(
    "clock", ["Elapsed time in milliseconds", "rel_time_ms", "Zeit seit Start/ms"]
)
def test_the_first_column_is_the_clock_where_it_speaks_of_time_and_a_unit_of_it(
    clock: str, tmp_path: Path
) -> None:
    recording = read(tmp_path, f"{clock},angle in deg")
    np.testing.assert_allclose(recording.time, [0.0, 1e-3])
    assert f"{clock} as time [" in recording.notes[0]


@pytest.mark.parametrize("clock", ["in ms", "time(ms)"])
def test_a_clock_of_an_oscilloscope_has_its_unit_in_its_name(tmp_path: Path, clock: str) -> None:
    recording = read(tmp_path, f"{clock},angle in deg")
    np.testing.assert_allclose(recording.time, [0.0, 1e-3])
    np.testing.assert_allclose(recording.signal("angle"), [0.0, np.pi / 90])


@pytest.mark.parametrize(
    "header",
    [
        "in deg,angle",
        "in,angle",
        "angle,in ms",
        "der(s),angle",
        "angle,dead_time_ms",
        "x_min,angle",
    ],
)
def test_what_does_not_name_a_time_is_no_clock(tmp_path: Path, header: str) -> None:
    with pytest.raises(RecordingError, match="expected a column 'time'"):
        read(tmp_path, header)
