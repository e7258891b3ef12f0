"""Read CSV: our own format, and files of loggers and spreadsheets.

Understood: `# name = value` lines, units in the header's brackets or in a row of their own,
`,`, `;` or tab between cells, decimal comma, quoted names, a byte-order mark, any line ends.
"""

from __future__ import annotations

import codecs
import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import RecordedChannels
from gmfbo.recordings.columns.columns import Column, RecordedColumns
from gmfbo.recordings.csv.head import read_head
from gmfbo.recordings.csv.header import read_header, read_units_row
from gmfbo.recordings.csv.large_table import (
    HEAD_BYTES,
    LARGE_BYTES,
    LARGEST_LENIENT_BYTES,
    LARGEST_LENIENT_LINES,
    read_numbers,
    refuse_lenient,
)
from gmfbo.recordings.csv.numbers import with_point
from gmfbo.recordings.csv.preamble import header_row, stated_delimiter
from gmfbo.recordings.csv.times import read_times
from gmfbo.recordings.csv.twincat_scope import is_scope_export, read_scope

_BLANK = {"", "nan", "NaN", "NAN"}
_QUOTED = re.compile(r'"[^"]*"')


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
    if size > LARGE_BYTES:
        try:
            return _read_large(path, label, dialect)
        except ValueError as error:  # not plain numbers: read cell by cell, if not too large
            if size > LARGEST_LENIENT_BYTES or _line_count(path) > LARGEST_LENIENT_LINES:
                raise refuse_lenient(label, size, error) from None
    lines = re.split(r"\r\n|\n|\r", _text(path.read_bytes(), label))
    top = next((line for line in lines if line.strip()), "")
    if dialect == "twincat_scope" or (
        dialect == "auto" and is_scope_export(lines, _delimiter(top))
    ):
        return read_scope(lines, _delimiter(top), label)
    return _read_table(lines, label, dialect)


def _line_count(path: Path) -> int:
    content = path.read_bytes()
    return content.count(b"\n") + content.count(b"\r")


def _read_large(path: Path, label: str, dialect: str) -> RecordedColumns:
    """Read a large plain table; its beginning is read like any other file."""
    with path.open("rb") as file:
        content = file.read(HEAD_BYTES)
    lines = content[: content.rfind(b"\n") + 1].decode("utf-8-sig").splitlines()
    if not lines or dialect == "twincat_scope" or is_scope_export(lines, _delimiter(lines[0])):
        raise ValueError("expected one header and rows")
    try:
        head = _read_table(lines, label, dialect)
        first = int(head.row_name(0).removeprefix("line "))
    except (RecordingError, IndexError) as error:
        raise ValueError(str(error)) from None
    rows = [line for line in lines[first - 1 :] if line.strip() and not line.startswith("#")]
    return read_numbers(path, head, _table_delimiter(rows), first)


def _read_table(lines: list[str], label: str, dialect: str) -> RecordedColumns:
    head = read_head([line for line in lines if line.lstrip().startswith("#")], label)
    places = [
        number
        for number, line in enumerate(lines, start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not places:
        raise RecordingError(
            f"{label}: expected a header such as 'time [s],position [rad]' and rows, got an empty "
            "file; record again"
        )
    stated = stated_delimiter(lines[places[0] - 1])
    places = places[1:] if stated and len(places) > 1 else places
    delimiter = stated or _table_delimiter([lines[place - 1] for place in places])
    table = _cells_of([lines[place - 1] for place in places], delimiter, label)
    above = 0 if head.notes.own else header_row(table)
    header, rows, places = table[above], table[above + 1 :], places[above:]
    if (
        len(header) > 1
        and not header[-1].strip()
        and not any("".join(r[len(header) - 1 :]).strip() for r in rows)
    ):
        header = header[:-1]  # a delimiter ends each line
    names, units = read_header(header, label)
    places = places[1:]
    below = read_units_row(rows[0]) if rows else None
    if below is not None:
        below += [""] * (len(units) - len(below))
        units = [unit or other for unit, other in zip(units, below, strict=False)]
        rows, places = rows[1:], places[1:]
    table_rows = _Rows(label, rows, places, delimiter, dialect)
    table_rows.check_width(len(names))
    columns = [
        table_rows.column(index, name, unit, infinite=head.notes.own)
        for index, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    start = "" if head.notes.own else table_rows.write_out_times(columns)
    return RecordedColumns(
        label=label,
        columns=tuple(columns),
        scalars=head.parameters,
        declared=True,
        unreadable=head.unreadable,
        notes=replace(head.notes, start_time=head.notes.start_time or start),
        row_name=lambda row: f"line {table_rows.places[row]}",
    )


def _cells_of(lines: list[str], delimiter: str, label: str) -> list[list[str]]:
    """Cells of each line; a cell must not span lines."""
    try:
        table = list(csv.reader(lines, delimiter=delimiter))
    except csv.Error:  # a cell beyond the module's limit of size
        table = []
    if len(table) != len(lines):
        raise RecordingError(f"{label}: a quotation mark is not closed; correct the file")
    return table


class _Rows:
    """Cells below the header, with the lines on which they stand."""

    def __init__(
        self,
        label: str,
        rows: list[list[str]],
        places: list[int],
        delimiter: str,
        dialect: str,
    ) -> None:
        self.label = label
        self.dialect = dialect
        self.delimiter = delimiter
        # A spreadsheet writes an empty line as a row of delimiters.
        keep = [k for k, row in enumerate(rows) if any(cell.strip() for cell in row)]
        self.rows = [rows[k] for k in keep]
        self.places = [places[k] for k in keep]

    def check_width(self, width: int) -> None:
        for row, place in zip(self.rows, self.places, strict=True):
            if len(row) < width or any(cell.strip() for cell in row[width:]):
                hint = (
                    "a decimal comma needs ';' between the cells"
                    if self.delimiter == "," and len(row) > width
                    else "complete or delete the line"
                )
                raise RecordingError(
                    f"{self.label}, line {place}: expected {width} cells as in the header, got "
                    f"{len(row)}; {hint}"
                )

    def column(self, index: int, name: str, unit: str, *, infinite: bool) -> Column:
        """Numbers of one column; `infinite` allows infinity, which a diverged run may hold."""
        cells = [row[index].strip() for row in self.rows]
        texts = ["nan" if cell in _BLANK else cell for cell in cells]
        texts = with_point(texts, self.delimiter, self.dialect)
        try:
            values = np.array(texts, dtype=np.float64) if texts else np.empty(0)
            # NumPy reads 1_000 as a thousand and 1e999 as infinity.
            sound = infinite or not np.isinf(values).any()
            if sound and not any("_" in text for text in texts):
                return Column(name, values, unit)
        except ValueError:
            pass
        return self._faulty(name, unit, cells, texts)

    def write_out_times(self, columns: list[Column]) -> str:
        """Convert columns of written times to seconds; returns the first one's start."""
        start = ""
        for index, column in enumerate(columns):
            if not column.fault or np.isfinite(column.values).any():
                continue
            read = read_times([row[index].strip() for row in self.rows])
            if read is not None:
                columns[index] = Column(column.name, read[0], "s")
                start = start or read[1]
        return start

    def _faulty(self, name: str, unit: str, cells: list[str], texts: list[str]) -> Column:
        values = np.full(len(cells), np.nan)
        fault = ""
        for row, text in enumerate(texts):
            number = _number(text)
            if number is not None:
                values[row] = number
            elif not fault:
                fault = (
                    f"{self.label}, line {self.places[row]}, column '{name}': expected a number, "
                    f"got '{cells[row]}'; correct the cell, or leave it blank if not sampled"
                )
        return Column(name, values, unit, fault)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return None if "_" in text or np.isinf(value) else value


def _delimiter(header: str) -> str:
    bare = _QUOTED.sub("", header)
    return next((mark for mark in (";", "\t", ",") if mark in bare), ",")


def _table_delimiter(lines: list[str]) -> str:
    """Delimiter on which the rows agree; lines above the table may have another or none."""
    tail = [_QUOTED.sub("", line) for line in lines[-20:]]
    for mark in (";", "\t"):
        if all(mark in line for line in tail):
            return mark
    return _delimiter(lines[0])


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
