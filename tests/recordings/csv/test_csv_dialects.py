"""CSV as loggers and spreadsheets write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gmfbo.recordings import Recording

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


def test_a_step_stays_a_step(tmp_path: Path) -> None:
    """Nothing is interpolated on reading."""
    recording = Recording.read(write(tmp_path, "time,r\n0,0\n1,0\n2,1\n3,1\n"))
    np.testing.assert_array_equal(recording.signal("r"), [0.0, 0.0, 1.0, 1.0])
