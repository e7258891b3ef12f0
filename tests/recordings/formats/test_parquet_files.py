"""Parquet files written by pyarrow and pandas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from tests.recordings.twin_words import AXIS

arrow: Any = pytest.importorskip(
    "pyarrow", reason="pyarrow is missing; pip install 'gmfbo[parquet]'"
)
parquet: Any = pytest.importorskip("pyarrow.parquet")

TIME = np.arange(50) * 1e-3


def write(path: Path, columns: dict[str, Any], units: dict[str, str] | None = None) -> Path:
    fields = [
        arrow.field(n, arrow.array(v).type, metadata={"unit": (units or {}).get(n, "")})
        for n, v in columns.items()
    ]
    table = arrow.table(list(map(arrow.array, columns.values())), schema=arrow.schema(fields))
    parquet.write_table(table.replace_schema_metadata({"ctl.Kp": "90.5", "who": "Eva"}), path)
    return path


def test_units_come_from_the_metadata_and_nulls_are_blank(tmp_path: Path) -> None:
    slow = [float(k) if k % 5 == 0 else None for k in range(50)]
    path = write(
        tmp_path / "run.parquet",
        {"time": TIME * 1e3, "reference": TIME, "position": TIME * 100.0, "speed": slow},
        {"time": "ms", "position": "deg", "speed": "rpm"},
    )
    recording = Recording.read(path, AXIS)
    np.testing.assert_allclose(recording.time, TIME, rtol=1e-15)
    np.testing.assert_allclose(recording.signal("position"), np.deg2rad(TIME * 100.0), rtol=1e-15)
    speed = recording.signal("speed")
    assert np.isnan(speed).sum() == 40
    np.testing.assert_allclose(speed[::5], np.arange(0, 50, 5) * np.pi / 30.0, rtol=1e-15)
    assert recording.parameters == {"ctl.Kp": 90.5}


@settings(max_examples=30, deadline=None)
@given(values=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=20))
def test_numbers_are_read_bit_by_bit(
    tmp_path_factory: pytest.TempPathFactory, values: list[float]
) -> None:
    path = tmp_path_factory.mktemp("bits") / "run.parquet"
    write(path, {"t": np.arange(len(values)) * 1.0, "a": np.array(values)})
    np.testing.assert_array_equal(Recording.read(path).signal("a"), values)


def test_an_index_of_points_in_time_is_the_clock_to_the_nanosecond(tmp_path: Path) -> None:
    pandas: Any = pytest.importorskip("pandas")
    index = pandas.DatetimeIndex(
        np.datetime64("2026-01-02T03:04:05") + np.arange(50) * np.timedelta64(125_001, "ns")
    )
    frame = pandas.DataFrame({"a [mrad]": np.arange(50), "n": np.arange(50) % 2 == 0}, index=index)
    frame.to_parquet(tmp_path / "run.parquet")
    recording = Recording.read(tmp_path / "run.parquet")
    np.testing.assert_allclose(recording.time, np.arange(50) * 125_001e-9, rtol=1e-15)
    assert recording.start_time.startswith("2026-01-02T03:04:05")
    np.testing.assert_allclose(recording.signal("a"), np.arange(50) * 1e-3, rtol=1e-15)
    np.testing.assert_array_equal(recording.signal("n")[:2], [1.0, 0.0])


def test_text_columns_are_left_out_and_refused_where_they_are_needed(tmp_path: Path) -> None:
    path = write(
        tmp_path / "run.parquet",
        {"time": TIME, "reference": TIME, "position": ["x"] * 50, "state": ["y"] * 50},
    )
    assert list(Recording.read(path).signals) == ["reference"]
    with pytest.raises(RecordingError, match=r"column 'position': expected numbers, got string"):
        Recording.read(path, AXIS)


def test_another_file_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "run.parquet"
    path.write_text("time,a\n0,1\n")
    with pytest.raises(RecordingError, match=r"run\.parquet: expected a Parquet file, got") as said:
        Recording.read(path)
    assert "\n" not in str(said.value)
