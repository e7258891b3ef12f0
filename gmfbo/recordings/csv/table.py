"""Read CSV: our own format, and files of loggers and spreadsheets.

Understood: `# name = value` lines, a header behind `#` or none at all, units in the header's
brackets or in a row of their own, `,`, `;`, tab or blanks between cells, decimal comma, quoted
names, a byte-order mark, any line ends.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import RecordedChannels
from gmfbo.recordings.columns.columns import Column, RecordedColumns, has_clock
from gmfbo.recordings.csv.cells import cells_of, separator_of_header, separator_of_table
from gmfbo.recordings.csv.commented_header import is_comment, with_bare_header
from gmfbo.recordings.csv.head import CsvHead, read_head
from gmfbo.recordings.csv.large_table import (
    HEAD_BYTES,
    LARGE_BYTES,
    LARGEST_LENIENT_BYTES,
    LARGEST_LENIENT_LINES,
    read_numbers,
    refuse_lenient,
)
from gmfbo.recordings.csv.layout import layout_of
from gmfbo.recordings.csv.lvm import is_lvm, read_lvm
from gmfbo.recordings.csv.oscilloscope import EvenClock
from gmfbo.recordings.csv.preamble import stated_delimiter
from gmfbo.recordings.csv.rohde_schwarz import (
    Properties,
    header_of,
    layout_of_values,
    refuse_header,
    refuse_without_header,
)
from gmfbo.recordings.csv.rows import Rows
from gmfbo.recordings.csv.twincat_scope import is_scope_export, read_scope


def read_csv(path: Path, dialect: str = "auto") -> RecordedColumns | RecordedChannels:
    """Read the columns of a CSV file.

    Parameters
    ----------
    path : Path
        File.
    dialect : str
        One of `gmfbo.recordings.columns.column_mapping.DIALECTS`; `auto` finds out.

    Raises
    ------
    RecordingError
        There is no table, or a row does not fit the header; names the line.
    OSError
        The file cannot be read.
    """
    label = path.name
    size = path.stat().st_size
    waveform = header_of(path)
    if size > LARGE_BYTES and waveform is None:
        try:
            return _read_large(path, label, dialect)
        except ValueError as error:  # not plain numbers: read cell by cell, if not too large
            if size > LARGEST_LENIENT_BYTES or _line_count(path) > LARGEST_LENIENT_LINES:
                raise refuse_lenient(label, size, error) from None
    if size > LARGEST_LENIENT_BYTES:
        raise refuse_lenient(label, size, ValueError("its names stand in another file"))
    lines = re.split(r"\r\n|\n|\r", _text(path.read_bytes(), label))
    if waveform is not None:
        return _read_table(lines, label, dialect, waveform)
    refuse_header(path, lines)
    top = next((line for line in lines if line.strip()), "")
    if dialect == "auto" and is_lvm(lines):
        return read_lvm(lines, label)
    if dialect == "twincat_scope" or (
        dialect == "auto" and is_scope_export(lines, separator_of_header(top))
    ):
        return read_scope(lines, separator_of_header(top), label)
    refuse_without_header(path, top.split(separator_of_header(top)))
    return _read_table(lines, label, dialect)


def _line_count(path: Path) -> int:
    content = path.read_bytes()
    return content.count(b"\n") + content.count(b"\r")


def _read_large(path: Path, label: str, dialect: str) -> RecordedColumns:
    """Read a large plain table; its beginning is read like any other file."""
    with path.open("rb") as file:
        content = file.read(HEAD_BYTES)
    lines = content[: content.rfind(b"\n") + 1].decode("utf-8-sig").splitlines()
    if (
        not lines
        or dialect == "twincat_scope"
        or is_scope_export(lines, separator_of_header(lines[0]))
    ):
        raise ValueError("expected one header and rows")
    try:
        if is_lvm(lines):
            raise ValueError("expected one table")
        head = _read_table(lines, label, dialect)
        first = int(head.row_name(0).removeprefix("line "))
    except (RecordingError, IndexError) as error:
        raise ValueError(str(error)) from None
    rows = [line for line in lines[first - 1 :] if line.strip() and not is_comment(line)]
    return read_numbers(path, head, separator_of_table(rows), first)


def _read_table(
    lines: list[str], label: str, dialect: str, waveform: Properties | None = None
) -> RecordedColumns:
    if not any(line.lstrip("# ").startswith("gmfbo") for line in lines[:1]):
        lines = with_bare_header(lines)
    comments, places = [], []
    for place, line in enumerate(lines, start=1):
        if is_comment(line):
            comments.append(line)
        elif line.strip():
            places.append(place)
    head = read_head(comments, label)
    if not places:
        raise RecordingError(
            f"{label}: expected a header such as 'time [s],position [rad]' and rows, got an empty "
            "file; record again"
        )
    stated = stated_delimiter(lines[places[0] - 1])
    places = places[1:] if stated and len(places) > 1 else places
    separator = stated or separator_of_table([lines[place - 1] for place in places])
    table = cells_of([lines[place - 1] for place in places], separator, label)
    if waveform is None:
        layout = layout_of(table, label, own=head.notes.own)
    else:
        layout = layout_of_values(table, waveform, label)
    rows = Rows(label, layout.rows, places[-len(layout.rows) :], separator, dialect)
    rows.check_width(len(layout.names))
    columns = [
        rows.column(index, name, unit, infinite=head.notes.own)
        for index, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True))
    ]
    start = "" if head.notes.own else rows.write_out_times(columns)
    columns = _with_even_clock(columns, layout.clock, sequence=layout.sequence)
    return _recorded(label, columns, head, rows, start)


def _recorded(
    label: str, columns: list[Column], head: CsvHead, rows: Rows, start: str
) -> RecordedColumns:
    return RecordedColumns(
        label=label,
        columns=tuple(columns),
        scalars=head.parameters,
        declared=True,
        unreadable=head.unreadable,
        notes=replace(head.notes, start_time=head.notes.start_time or start),
        row_name=lambda row: f"line {rows.places[row]}",
    )


def _with_even_clock(
    columns: list[Column], clock: EvenClock | None, *, sequence: bool
) -> list[Column]:
    """Columns with the times that a header states by start and increment, if they have none."""
    if clock is None or not columns:
        return columns
    if sequence:
        numbers = columns[0].values
        times = Column(columns[0].name, clock.start + clock.step * numbers, "s", columns[0].fault)
        return [times, *columns[1:]]
    if has_clock(tuple(columns)):
        return columns
    count = np.arange(columns[0].values.size, dtype=np.float64)
    return [Column("time", clock.start + clock.step * count, "s"), *columns]


def _text(content: bytes, label: str) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    if b"\0" in content:
        raise RecordingError(
            f"{label}: expected text, got a binary file; export the recording as CSV, or give "
            "the file its right ending"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")  # what Windows loggers write
