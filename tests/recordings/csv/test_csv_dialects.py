"""CSV as loggers and spreadsheets write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.recording import read_recording
from tests.recordings.twin_words import TwinWords

AXIS_WITHOUT_NEEDS = TwinWords((SignalSpec("position", "position", unit="rad"),))

# Each holds time 0.000, 0.001, 0.002 s and position 0, 0.5, -1 rad, or the same in other units.
DIALECTS = {
    "plain": "time,position\n0,0\n0.001,0.5\n0.002,-1\n",
    "units in brackets": "time [s],position [rad]\n0,0\n1e-3,5e-1\n2e-3,-1\n",
    "units without a blank": "time[s],position[rad]\n0,0\n0.001,0.5\n0.002,-1\n",
    "units in parentheses": "Time (ms),position (rad)\n0,0\n1,0.5\n2,-1\n",
    "milliseconds": "time [ms],position [mrad]\n0,0\n1,500\n2,-1000\n",
    "clock named by its unit": "position,stamp [ms]\n0,0\n0.5,1\n-1,2\n",
    "clock beside a temperature": "T [degC],stamp [ms],position\n20,0,0\n20,1,0.5\n20,2,-1\n",
    "semicolon and decimal comma": "time;position\n0;0\n0,001;0,5\n0,002;-1,0\n",
    "tabs": "time\tposition\n0\t0\n0.001\t0.5\n0.002\t-1\n",
    "quoted names": '"time [s]","position [rad]"\n0,0\n0.001,0.5\n0.002,-1\n',
    "units row": "time,position\nms,mrad\n0,0\n1,500\n2,-1000\n",
    "units row in brackets": "time;position\n[s];[mrad]\n0;0\n0,001;500\n0,002;-1000\n",
    "remarks and blank lines": "# drive 7\n\ntime,position\n0,0\n\n0.001,0.5\n# end\n0.002,-1\n\n",
    "delimiter at line ends": "time,position,\n0,0,\n0.001,0.5,\n0.002,-1,\n",
    "rows of delimiters": "time;position\n0;0\n0,001;0,5\n0,002;-1\n;\n;\n",
    "blanks around cells": " time , position \n 0 , 0 \n 0.001 , 0.5 \n 0.002 , -1 \n",
    "no newline at the end": "time,position\n0,0\n0.001,0.5\n0.002,-1",
    "blanks": "time position\n0 0\n0.001 0.5\n0.002 -1\n",
    "many blanks": "   time   position\n   0.0      0\n   0.001    0.5\n   0.002   -1\n",
    "blanks and units": "time [ms]  position [mrad]\n0  0\n1  500\n2  -1000\n",
    "blanks and one blank before the units": "time [ms] position [mrad]\n0 0\n1 500\n2 -1000\n",
    "blanks and decimal commas": "time position\n0,0 0,0\n0,001 0,5\n0,002 -1,0\n",
    "commas with a blank behind": "time, position\n0, 0\n0.001, 0.5\n0.002, -1\n",
    "header behind #": "# time,position\n0,0\n0.001,0.5\n0.002,-1\n",
    "header behind #, blanks": "# drive 7\n# time position\n0 0\n0.001 0.5\n0.002 -1\n",
    "header behind #, below a value": "# kp = 7\n# time position\n0 0\n0.001 0.5\n0.002 -1\n",
    "header and units behind #": "# time position\n# ms mrad\n0 0\n1 500\n2 -1000\n",
    "header behind %": "% run 1\n% time position\n0 0\n0.001 0.5\n0.002 -1\n",
    "labels below the header": "time,position\nclock,angle\ns,rad\n0,0\n0.001,0.5\n0.002,-1\n",
    "labels above the header": "a,b\nc,d\ntime,position\nms,mrad\n0,0\n1,500\n2,-1000\n",
    "units in words": "x,position\nSecond,Radian\n0,0\n0.001,0.5\n0.002,-1\n",
    "a unit, and the clock's name": "time,position\n,mrad\n0,0\n0.001,500\n0.002,-1000\n",
    "two columns that nobody needs": "time,a,a,position\n0,1,2,0\n0.001,1,2,0.5\n0.002,1,2,-1\n",
    "row number without a name": ",time,position\n0,0,0\n1,0.001,0.5\n2,0.002,-1\n",
}


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "run.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS.keys())
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_each_dialect_holds_the_same_numbers(tmp_path: Path, text: str, ends: str) -> None:
    recording = Recording.read(write(tmp_path, text.replace("\n", ends)))
    np.testing.assert_array_equal(recording.time, [0.0, 0.001, 0.002])
    np.testing.assert_array_equal(recording.signal("position"), [0.0, 0.5, -1.0])
    assert recording.written_by == ""


@pytest.mark.parametrize("sign", ["", "# ", "% "])
@pytest.mark.parametrize("between", ["\t", ",", ";"])
def test_names_set_apart_by_blanks_stand_above_rows_that_are_not(
    tmp_path: Path, sign: str, between: str
) -> None:
    path = tmp_path / "run.txt"
    rows = "".join(f"{k * 1e-3}{between}{0.5 * k}\n" for k in range(4))
    path.write_text(f"{sign}time position\n{rows}")
    np.testing.assert_array_equal(Recording.read(path).signal("position"), [0.0, 0.5, 1.0, 1.5])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings_of_a_degree_sign(tmp_path: Path, encoding: str) -> None:
    text = "time [s];Winkel [°]\n0;0\n0,001;180\n"
    recording = Recording.read(write(tmp_path, text, encoding))
    np.testing.assert_allclose(recording.signal("Winkel"), [0.0, np.pi], rtol=1e-15)
    assert recording.units["Winkel"] == "rad"


def test_a_blank_cell_is_not_sampled(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path, "time,a,b\n0,1,\n1,2,nan\n2,3,7\n"))
    np.testing.assert_array_equal(recording.signal("b"), [np.nan, np.nan, 7.0])


def test_lines_above_the_header_are_parameters_and_what_may_be_scored(tmp_path: Path) -> None:
    text = (
        "# gains of the second run\n# ctl.Kp = 90.5\n# ctl.Kd=4,25\n# use = 0.5:1.5\n"
        "# operator = Eva\n# start_time = 2026-01-02T03:04:05\ntime,a\n0,1\n1,2\n2,3\n"
    )
    recording = Recording.read(write(tmp_path, text))
    assert recording.parameters == {"ctl.Kp": 90.5, "ctl.Kd": 4.25}
    assert recording.use == (0.5, 1.5)
    assert recording.start_time == "2026-01-02T03:04:05"


def test_an_unknown_unit_is_kept_as_text_and_counts_as_counts(tmp_path: Path) -> None:
    text = "time,a [widgets],b [inc],c [-]\n0,1,2,3\n1,1,2,3\n"
    recording = Recording.read(write(tmp_path, text))
    assert recording.units == {"a": "widgets", "b": "counts", "c": "1"}


def test_elements_of_arrays_are_not_taken_for_units(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path, 'time,"m[1,2] [Nm]",x[3]\n0,1,2\n1,1,2\n'))
    assert list(recording.signals) == ["m[1,2]", "x[3]"]
    assert recording.units == {"m[1,2]": "N.m"}


def test_a_column_of_text_is_left_out(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path, "time,state,a\n0,INIT,1\n1,RUN,2\n"))
    assert list(recording.signals) == ["a"]


def test_a_value_behind_a_hash_is_no_header_of_two_columns(tmp_path: Path) -> None:
    """Negative control of headers behind `#`: `# kp 90` has two cells too."""
    with pytest.raises(RecordingError, match=r"got columns column 1, column 2"):
        Recording.read(write(tmp_path, "# kp 90\n0 1\n1 2\n"))


def test_a_column_whose_name_begins_with_a_percent_sign_is_kept(tmp_path: Path) -> None:
    recording = Recording.read(write(tmp_path, "%load,time\n5,0\n6,1\n"))
    assert list(recording.signals) == ["%load"]


def test_equal_names_are_numbered_and_can_be_mapped(tmp_path: Path) -> None:
    path = write(tmp_path, "time,q,q\n0,1,2\n1,1,2\n")
    mapping = ColumnMapping({"position": MappedColumn("q (2)")})
    recording = read_recording(path, AXIS_WITHOUT_NEEDS, mapping=mapping)
    np.testing.assert_array_equal(recording.signal("position"), [2.0, 2.0])


def test_a_file_without_header_and_clock_is_read_by_places_and_sample_time(tmp_path: Path) -> None:
    path = write(tmp_path, "0 0.5\n1 0.6\n2 0.7\n")
    clock = MappedColumn("", sample_time=2e-3)
    mapping = ColumnMapping({"time": clock, "position": MappedColumn("column 2")})
    recording = read_recording(path, AXIS_WITHOUT_NEEDS, mapping=mapping)
    np.testing.assert_array_equal(recording.time, [0.0, 2e-3, 4e-3])
    np.testing.assert_array_equal(recording.signal("position"), [0.5, 0.6, 0.7])


def test_a_large_table_set_apart_by_blanks_is_read_as_a_small_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "# time q\n" + "".join(f"{k / 1000:.3f}  {k / 7:.6f}\n" for k in range(500))
    path = write(tmp_path, text)
    small = Recording.read(path)
    monkeypatch.setattr("gmfbo.recordings.csv.table.LARGE_BYTES", 1000)
    large = Recording.read(path)
    np.testing.assert_array_equal(small.time, large.time)
    np.testing.assert_array_equal(small.signal("q"), large.signal("q"))


WRITTEN_TIMES = {
    "AM and PM": ("11:59:59.9 AM", "12:00:00.0 PM"),
    "past midnight": ("23:59:59.95", "00:00:00.05"),
    "midnight of half days": ("11:59:59.9 PM", "12:00:00.0 AM"),
    "month first": ("1/2/2026 3:04:05.0 PM", "1/2/2026 3:04:05.1 PM"),
    "year first": ("2016/08/11 15:37:48.375", "2016/08/11 15:37:48.475"),
    "durations of pandas": ("0 days 00:00:01.25", "0 days 00:00:01.35"),
    "durations around zero": ("-1 days +23:59:59.95", "0 days 00:00:00.05"),
}


@pytest.mark.parametrize(("first", "second"), WRITTEN_TIMES.values(), ids=WRITTEN_TIMES.keys())
def test_written_times_are_a_tenth_of_a_second_apart(
    tmp_path: Path, first: str, second: str
) -> None:
    recording = Recording.read(write(tmp_path, f"time,a\n{first},1\n{second},2\n"))
    assert recording.duration == pytest.approx(0.1, abs=1e-10)


def test_date_and_time_in_two_columns(tmp_path: Path) -> None:
    text = "Date,Time,a\n2026-01-02,23:59:59.9,1\n2026-01-03,00:00:00.0,2\n"
    recording = Recording.read(write(tmp_path, text))
    assert recording.duration == pytest.approx(0.1, abs=1e-10)
    assert recording.start_time == "2026-01-02"


def test_a_time_that_falls_by_a_minute_is_no_midnight(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="time goes back"):
        Recording.read(write(tmp_path, "time,a\n00:02:00,1\n00:01:00,2\n"))


def test_a_step_stays_a_step(tmp_path: Path) -> None:
    """Nothing is interpolated on reading."""
    recording = Recording.read(write(tmp_path, "time,r\n0,0\n1,0\n2,1\n3,1\n"))
    np.testing.assert_array_equal(recording.signal("r"), [0.0, 0.0, 1.0, 1.0])
