"""Each bad recording gives one line that says where, what was expected and what to do."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from gmfbo.recordings.store.study_folder import StudyStore
from tests.recordings.twin_words import AXIS

# Text of the file, and what the message holds.
BAD_CSV = {
    "empty file": ("", "got an empty file"),
    "only remarks": ("# a = 1\n", "got an empty file"),
    "no rows": ("time,a\n", "at least one row, got no row"),
    "only a units row": ("time,a\ns,rad\n", "at least one row, got no row"),
    "no header, no clock": ("0,1\n1,2\n", r"got columns column 1, column 2; .* sample_time = "),
    "no header in a file of ours": (
        "# gmfbo = 0.1.0\n0,1\n1,2\n",
        "expected a header .* got numbers; add a line",
    ),
    "no clock": ("a,b\n0,1\n", "expected a column 'time' or 't'.* got columns a, b"),
    "clock in metres": ("time [m],a\n0,1\n", r"a unit of time such as \[s\] or \[ms\], got \[m\]"),
    "text in a cell": (
        "time,a\n0,1\n1,abc\n2,3\n",
        "line 3, column 'a': expected a number, got 'abc'; correct the cell",
    ),
    "text in the clock": ("time,a\n0,1\nx,2\n", "line 3, column 'time': .* got 'x'"),
    "infinity": ("time,a\n0,1\n1,inf\n", "line 3, column 'a': expected a number, got 'inf'"),
    "underscore in a number": ("time,a\n0,1\n1,1_0\n", "line 3, column 'a': .* got '1_0'"),
    "thousands separator": ("time;a\n0;1.5\n1;1,234.5\n", "line 3, column 'a': .* '1,234.5'"),
    "comma beside point": ("time;a\n0;1.5\n1;1,234\n", "line 3, column 'a': .* got '1,234'"),
    "text beside decimal commas": ("time;a\n0;1,5\n1;n.a.\n", "line 3, column 'a': .* 'n.a.'"),
    "text below a row of delimiters": ("time;a\n0;1\n;\n1;x\n", "line 4, column 'a': .* 'x'"),
    "short row": ("time,a\n0,1\n1\n", "line 3: expected 2 cells as in the header, got 1; complete"),
    "cut last row": ("time,a,b\n0,1,2\n1,2", "line 3: expected 3 cells .* got 2"),
    "decimal comma between commas": ("time,a\n0,1\n0,1,5\n", "decimal comma needs ';'"),
    "open quotation": ('time,"a\n0,1\n1,2\n', "a quotation mark is not closed"),
    "binary file": ("time,a\n\0\0\n", "expected text, got a binary file"),
    "NaN in time": ("time,a\n0,1\n,2\n2,3\n", "line 3: expected a finite time"),
    "time with too few digits": (
        "time,a\n0,1\n0,2\n1,2\n1,3\n2,3\n",
        "line 3: time 0 s stands twice with different values.* log time with enough digits",
    ),
    "three values at one time": (
        "time,a\n0,1\n1,1\n2,2\n2,3\n2,4\n3,4\n4,5\n",
        "line 5: time 2 s stands twice with different values",
    ),
    "time goes back": ("time,a\n0,1\n2,2\n1,3\n", "line 4: time goes back from 2 s to 1 s"),
    "gap": (
        "time,a\n" + "".join(f"{k},0\n" for k in (0, 1, 2, 3, 7, 8)),
        "line 6, at 7 s: there is a gap of 4 s, expected steps of about 1 s; cut .* resample = 1 ",
    ),
    "a changed line of ours": (
        "# gmfbo = 0.1.0\n# gmfbo.status = ok\ntime,a\n0,1\n1,2\n",
        "'# gmfbo.status = ok': expected a number or a quoted text; restore",
    ),
    "a row of units shorter than the header": (
        "time [ms],a [rad],b\nΩ\n1,1,0\n2,x,0\n",
        "line 4, column 'a': expected a number, got 'x'",
    ),
    "a text of thousands of letters": (
        "time,a\n0,1\n1," + "x" * 9000 + "\n",
        r"line 3, column 'a': .* \.\.\. x+'; correct the cell, or leave it blank",
    ),
    "use of nothing": ("# use = 5:6\ntime,a\n0,1\n1,2\n", "use = 5:6 selects nothing"),
    "use backwards": ("# use = 1:0\ntime,a\n0,1\n1,2\n", "use = 1:0 selects nothing"),
    "use without an end": ("# use = 1\ntime,a\n0,1\n", "expected first and last time in seconds"),
}

BAD_FOR_THE_AXIS = {
    "a signal's name on two columns": (
        "time,reference,reference\n0,1,2\n1,1,2\n",
        r"2 columns are named 'reference': .* reference = \"reference \(1\)\" in the twin file",
    ),
    "missing column": (
        "time,Referenz,position\n0,1,1\n",
        r"no column 'reference' for .* did you mean 'Referenz'\?; 'gmfbo columns' shows",
    ),
    "another quantity": (
        "time,reference,position [deg/s]\n0,1,1\n1,2,2\n",
        r"column 'position': expected \[rad\] or a multiple .* got \[deg/s\]; correct the unit",
    ),
    "frequency for speed": (
        "time,reference,speed [Hz]\n0,1,1\n1,2,2\n",
        r"expected \[rad/s\] or a multiple for signal 'speed', got \[Hz\]",
    ),
    "counts without a scale": (
        "time,reference,position [counts]\n0,1,1\n1,2,2\n",
        r"have no SI value of their own, expected \[rad\]; give 'scale' \(\[rad\] per count\)",
    ),
    "unknown unit": (
        "time,reference,position [widgets]\n0,1,1\n1,2,2\n",
        r"unit \[widgets\] of signal 'position' is not known, expected \[rad\]",
    ),
    "none of the signals": ("time,a\n0,1\n", "no column 'reference' for signal 'reference'"),
    "a required column left blank": (
        "time,reference,position\n0,,1\n1,,2\n",
        "column 'reference' .* got blank cells only",
    ),
    "a parameter fixed during a run changes": (
        "time,reference,mech.J\n0,1,0.1\n1,1,0.1\n2,1,0.2\n",
        r"'mech.J' changes at 2 s \(line 4\) from 0.1 to 0.2, but this FMU parameter is fixed",
    ),
    "a schedule begins blank": (
        "time,reference,ctl.Kp\n0,1,\n1,1,90\n",
        "'ctl.Kp' is an FMU parameter: expected a value in the first row",
    ),
    "a gain's name in another case": (
        "# ctl.kp = 90\ntime,reference\n0,1\n1,1\n",
        "no FMU parameter 'ctl.kp'; did you mean 'ctl.Kp'",
    ),
    "a gain that is no number": (
        "# ctl.Kp = 9o\ntime,reference\n0,1\n1,1\n",
        "'# ctl.Kp = 9o': expected a number for this FMU parameter",
    ),
}


def one_line(error: pytest.ExceptionInfo[RecordingError], label: str) -> str:
    message = str(error.value)
    assert "\n" not in message
    assert label in message
    return message


@pytest.mark.parametrize(("text", "match"), BAD_CSV.values(), ids=BAD_CSV.keys())
def test_a_bad_csv_file_is_refused(tmp_path: Path, text: str, match: str) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(text.encode())
    with pytest.raises(RecordingError, match=match) as error:
        Recording.read(path)
    one_line(error, "run.csv")


@pytest.mark.parametrize(("text", "match"), BAD_FOR_THE_AXIS.values(), ids=BAD_FOR_THE_AXIS.keys())
def test_a_file_that_does_not_fit_the_twin_is_refused(
    tmp_path: Path, text: str, match: str
) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(text.encode())
    with pytest.raises(RecordingError, match=match) as error:
        Recording.read(path, AXIS)
    one_line(error, "run.csv")


def test_a_missing_file_is_told_with_the_nearest_name(tmp_path: Path) -> None:
    (tmp_path / "run1.csv").write_text("time,a\n0,1\n", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"no such file; did you mean 'run1\.csv'"):
        Recording.read(tmp_path / "run2.csv")


def test_another_ending_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"ends in \.csv, .* got '\.xlsx'; export it"):
        Recording.read(tmp_path / "run.xlsx")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(RecordingError, match="expected a recording, got a folder"):
        Recording.read(tmp_path / "folder.csv")


def test_a_file_without_right_to_read_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the operating system's border: the super-user may read whatever the rights say."""

    def refuse(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(self))

    path = tmp_path / "run.csv"
    path.write_text("time,a\n0,1\n", encoding="utf-8")
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(RecordingError, match=r"run\.csv: cannot be read: no permission"):
        Recording.read(path)


@pytest.mark.parametrize(
    ("ending", "match"),
    [(".h5", "expected an HDF5 file, got something else"), (".mat", "expected a MATLAB file")],
)
@pytest.mark.parametrize("content", [b"", b"time,a\n0,1\n", b"\x89HDF\r\n\x1a\n" + bytes(40)])
def test_what_is_no_hdf5_or_matlab_file_is_refused(
    tmp_path: Path, ending: str, match: str, content: bytes
) -> None:
    path = tmp_path / f"run{ending}"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=match) as error:
        Recording.read(path)
    one_line(error, path.name)


def test_a_cut_off_matlab_file_is_refused(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mat"
    scipy.io.savemat(whole, {"t": np.arange(500.0), "a": np.arange(500.0)})
    cut = tmp_path / "cut.mat"
    cut.write_bytes(whole.read_bytes()[:3000])
    with pytest.raises(RecordingError, match=r"cut\.mat: expected a MATLAB file"):
        Recording.read(cut)


def test_vectors_of_unequal_length_are_refused_where_needed(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"t": np.arange(3.0), "reference": np.ones(3), "position": np.ones(2)})
    with pytest.raises(RecordingError, match="'position' has 2 values, expected 3 as the clock"):
        Recording.read(path, AXIS)


@pytest.mark.parametrize("content", [{"x": 1.0}, {"name": "text"}])
def test_a_file_without_vectors_is_refused(tmp_path: Path, content: dict[str, object]) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, content)
    with pytest.raises(RecordingError, match="expected vectors of equal length"):
        Recording.read(path)


def test_vectors_without_a_clock_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"X": np.ones(4), "y": np.ones(4)})
    with pytest.raises(RecordingError, match=r"one in .* got columns X, y; say which is the clock"):
        Recording.read(path)


def test_the_index_of_a_study_is_not_a_recording(tmp_path: Path) -> None:
    StudyStore.create(tmp_path / "a.study", "").close()
    with pytest.raises(RecordingError, match="expected one recording, got a study of 0 trials"):
        Recording.read(tmp_path / "a.study" / "index.h5")


def test_nan_in_the_clock_of_an_hdf5_file_names_the_row(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["time"] = [0.0, 1.0, np.nan]
        file["a"] = [1.0, 2.0, 3.0]
    with pytest.raises(RecordingError, match=re.escape("run.h5, row 3: expected a finite time")):
        Recording.read(path)
