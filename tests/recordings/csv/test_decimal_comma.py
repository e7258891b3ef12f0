"""Exports with decimal commas, lines above the table and times written out."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gmfbo.errors import RecordingError
from gmfbo.recordings import Recording
from gmfbo.recordings.columns.column_mapping import ColumnMapping
from gmfbo.recordings.csv.numbers import with_point
from gmfbo.recordings.csv.times import read_times
from gmfbo.recordings.recording import read_recording

EXPORT = (
    "sep=;\r\nGerät;Achse 7, links\r\nDatum;02.01.2026 03:04:05\r\nKp;90,5\r\n\r\n"
    "Zeit;Lage;Moment\r\n[ms];[°];[Nm]\r\n0;0,5;1.234,5\r\n0,5;1,0;-2\r\n1;1,5;\r\n"
)


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "run.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_lines_above_the_table_are_passed_over(tmp_path: Path, encoding: str) -> None:
    recording = Recording.read(write(tmp_path, EXPORT, encoding))
    np.testing.assert_allclose(recording.time, [0.0, 0.5e-3, 1e-3], rtol=1e-15)
    np.testing.assert_allclose(recording.signal("Lage"), np.deg2rad([0.5, 1.0, 1.5]), rtol=1e-15)
    np.testing.assert_array_equal(recording.signal("Moment"), [1234.5, -2.0, np.nan])
    assert recording.parameters == {}


@settings(max_examples=60, deadline=None)
@given(
    values=st.lists(
        st.decimals(min_value=-(10**7), max_value=10**7, places=4), min_size=1, max_size=12
    ),
    thousands=st.sampled_from(["", ".", " ", "'"]),
)
def test_numbers_with_a_decimal_comma_are_read_as_they_were_meant(
    values: list[float], thousands: str
) -> None:
    cells = [
        f"{value:,.4f}".replace(",", "T").replace(".", ",").replace("T", thousands)
        for value in values
    ]
    read = [float(cell) for cell in with_point(cells, ";", "decimal_comma")]
    assert read == [float(value) for value in values]


@settings(max_examples=60, deadline=None)
@given(values=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=12))
def test_a_decimal_comma_is_found_without_a_name(values: list[float]) -> None:
    cells = [repr(value).replace(".", ",") for value in values]
    assert [float(cell) for cell in with_point(cells, ";", "auto")] == values


def test_quoted_decimal_commas_between_commas_need_the_dialect(tmp_path: Path) -> None:
    path = write(tmp_path, 'time,a\n"0","0,5"\n"0,001","1,5"\n"0,002","2,5"\n')
    with pytest.raises(RecordingError, match=r"expected a number, got '0,001'"):
        Recording.read(path)
    recording = read_recording(path, mapping=ColumnMapping({}, dialect="decimal_comma"))
    np.testing.assert_array_equal(recording.signal("a"), [0.5, 1.5, 2.5])


def test_a_decimal_point_in_a_file_of_decimal_commas_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "time;a\n0;0,5\n1;1.5\n")
    with pytest.raises(RecordingError, match=r"line 3, column 'a': expected a number, got '1\.5'"):
        read_recording(path, mapping=ColumnMapping({}, dialect="decimal_comma"))


FORMS = {
    "clock with a point": "%H:%M:%S.%f",
    "clock with a comma": "%H:%M:%S,%f",
    "ISO 8601": "%Y-%m-%dT%H:%M:%S.%f",
    "ISO 8601 with a zone": "%Y-%m-%dT%H:%M:%S.%f+01:00",
    "ISO 8601 with a blank": "%Y-%m-%d %H:%M:%S,%f",
    "day first": "%d.%m.%Y %H:%M:%S,%f",
}


@settings(max_examples=40, deadline=None)
@given(
    form=st.sampled_from(sorted(FORMS)),
    second=st.integers(min_value=0, max_value=80_000),
    step=st.integers(min_value=1, max_value=10**6),
)
def test_written_times_are_seconds_to_the_microsecond(form: str, second: int, step: int) -> None:
    start = datetime(2026, 1, 2) + timedelta(seconds=second)
    texts = [(start + timedelta(microseconds=k * step)).strftime(FORMS[form]) for k in range(5)]
    read = read_times(texts)
    assert read is not None
    expected = np.arange(5) * step * 1e-6 + (0 if "%Y" in FORMS[form] else second)
    np.testing.assert_allclose(read[0], expected, rtol=1e-14, atol=1e-12)
    assert (read[1] == "") == ("%Y" not in FORMS[form])
    if read[1]:
        assert datetime.fromisoformat(read[1]).replace(tzinfo=None) == start


def test_a_column_of_written_times_is_the_clock(tmp_path: Path) -> None:
    text = "Datum;Lage\n02.01.2026 23:59:59,999;1\n03.01.2026 00:00:00,000;2\n"
    recording = Recording.read(write(tmp_path, text))
    np.testing.assert_allclose(recording.time, [0.0, 1e-3], atol=1e-15)
    assert recording.start_time == "2026-01-02T23:59:59.999"


@pytest.mark.parametrize("text", ["12:61:00", "31.04.2026 00:00:00", "noon", "1:2"])
def test_what_is_no_time_is_not_taken_for_one(text: str) -> None:
    assert read_times([text]) is None
