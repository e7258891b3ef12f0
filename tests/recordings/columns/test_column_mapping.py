"""Columns renamed by a mapping before the twin reads them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording, SignalSpec
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.recording import read_recording
from gmfbo.recordings.writing.writer import write_recording
from tests.recordings.twin_words import AXIS, TwinWords

ROWS = "Takt;Soll;Ist;KP_ACT\n0;0;0;90\n1;0,5;90;90\n2;1;180;90\n"
MAPPING = ColumnMapping(
    {
        "time": MappedColumn("Takt", unit="ms"),
        "reference": MappedColumn("Soll"),
        "position": MappedColumn("Ist", unit="deg"),
        "ctl.Kp": MappedColumn("KP_ACT"),
    }
)


def write(folder: Path, text: str = ROWS) -> Path:
    path = folder / "run.csv"
    path.write_text(text)
    return path


def test_columns_get_the_names_and_units_of_the_mapping(tmp_path: Path) -> None:
    recording = read_recording(write(tmp_path), AXIS, mapping=MAPPING)
    np.testing.assert_allclose(recording.time, [0.0, 1e-3, 2e-3], rtol=1e-15)
    np.testing.assert_allclose(recording.signal("position"), [0.0, np.pi / 2, np.pi], rtol=1e-15)
    np.testing.assert_array_equal(recording.schedules["ctl.Kp"], [90.0, 90.0, 90.0])
    assert set(recording.signals) == {"reference", "position"}


def test_a_mapping_that_says_what_numbers_are_replaces_the_twin_s_scale(tmp_path: Path) -> None:
    counts = SignalSpec("position", "pos_counts", scale=1e-3, scaled=True, offset=7.0, unit="rad")
    twin = TwinWords((SignalSpec("reference", "reference", unit="rad"), counts))
    recording = read_recording(write(tmp_path), twin, mapping=MAPPING)
    np.testing.assert_allclose(recording.signal("position"), [0.0, np.pi / 2, np.pi], rtol=1e-15)
    plain = replace(MAPPING, columns={**MAPPING.columns, "position": MappedColumn("Ist")})
    recording = read_recording(write(tmp_path), twin, mapping=plain)
    np.testing.assert_allclose(recording.signal("position"), [7.0, 7.09, 7.18], rtol=1e-15)


def test_scale_and_offset_of_the_mapping_apply(tmp_path: Path) -> None:
    entry = MappedColumn("Ist", unit="deg", scale=0.5, offset=90.0)
    mapping = ColumnMapping({**MAPPING.columns, "position": entry})
    recording = read_recording(write(tmp_path), AXIS, mapping=mapping)
    np.testing.assert_allclose(
        recording.signal("position"), np.deg2rad([90.0, 135.0, 180.0]), rtol=1e-15
    )


def test_a_file_of_ours_is_read_as_without_the_mapping(tmp_path: Path) -> None:
    made = Recording(
        time=np.arange(3.0) * 1e-3,
        signals={"reference": np.arange(3.0), "position": np.ones(3), "Ist": np.zeros(3)},
        written_by="0.1.0",
    )
    path = write_recording(made, tmp_path / "ours.csv")
    recording = read_recording(path, AXIS, mapping=MAPPING)
    np.testing.assert_array_equal(recording.signal("position"), np.ones(3))


def test_columns_that_the_file_lacks_leave_the_twin_s_own_words(tmp_path: Path) -> None:
    path = write(tmp_path, "time,reference,position\n0,0,1\n1,1,2\n")
    recording = read_recording(path, AXIS, mapping=MAPPING)
    np.testing.assert_array_equal(recording.signal("position"), [1.0, 2.0])


def test_a_bad_cell_is_named_as_it_stands_in_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, ROWS.replace("180", "abc"))
    with pytest.raises(RecordingError, match=r"line 4, column 'Ist': expected a number, got 'abc'"):
        read_recording(path, AXIS, mapping=MAPPING)


def test_numpy_numbers_in_use_are_written_so_that_they_are_read(tmp_path: Path) -> None:
    made = Recording(
        time=np.arange(5.0) * 0.1,
        signals={"a": np.arange(5.0)},
        use=(np.float64(0.1), np.float32(0.25)),  # type: ignore[arg-type]
    )
    path = write_recording(made, tmp_path / "run.csv")
    assert "# use = 0.1:0.25\n" in path.read_text()
    assert Recording.read(path).use == (0.1, 0.25)
