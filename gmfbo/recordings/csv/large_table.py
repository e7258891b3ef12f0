"""Read CSV of many rows in bounded memory, by NumPy's parser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from gmfbo.errors import RecordingError, in_short
from gmfbo.recordings.columns.columns import Column, RecordedColumns
from gmfbo.recordings.csv.cells import BLANKS

LARGE_BYTES = 16 * 2**20
LARGEST_LENIENT_BYTES = 256 * 2**20
LARGEST_LENIENT_LINES = 4_000_000
"""Above either, only plain files are read: cell by cell, a line takes half a kB."""

HEAD_BYTES = 2**18


def read_numbers(path: Path, head: RecordedColumns, delimiter: str, first: int) -> RecordedColumns:
    """Read the rows of a plain table: numbers with a decimal point, or blank, in every cell.

    Parameters
    ----------
    path : Path
        UTF-8 text.
    head : RecordedColumns
        The beginning of the file, as it was read.
    delimiter : str
        Between cells.
    first : int
        Line (from 1) of the first row.

    Returns
    -------
    RecordedColumns
        With all rows, about 8 bytes a cell.

    Raises
    ------
    ValueError
        A cell is no number, or a row has another number of cells.
    """
    with path.open(encoding="utf-8-sig", newline=None) as lines:
        table = np.loadtxt(
            _filled(lines, delimiter, first),
            delimiter=None if delimiter == BLANKS else delimiter,
            comments="#",
            ndmin=2,
        )
    if table.shape[1] != len(head.columns) or (not head.notes.own and np.isinf(table).any()):
        raise ValueError("expected a finite number in each cell below the header")
    columns = tuple(
        Column(column.name, np.ascontiguousarray(table[:, k]), column.unit)
        for k, column in enumerate(head.columns)
    )
    return replace(head, columns=columns, row_name=lambda row: f"row {row + 1} below the header")


def refuse_lenient(label: str, size: int, error: ValueError) -> RecordingError:
    """Error for a file that is too large to be read cell by cell."""
    return RecordingError(
        f"{label}: a file of {size / 1e6:.0f} MB must be a plain table of numbers "
        f"({in_short(error)}); correct it, cut it into shorter ones, or export .h5 or .parquet"
    )


def _filled(lines: Iterator[str], delimiter: str, first: int) -> Iterator[str]:
    """Rows with `nan` where a cell is blank."""
    twice = delimiter * 2
    for number, line in enumerate(lines, start=1):
        if number < first:
            continue
        line = line.rstrip("\n")
        if delimiter == BLANKS:
            yield line
        elif twice in line or line.startswith(delimiter) or line.endswith(delimiter):
            cells = line.split(delimiter)
            yield delimiter.join(cell if cell.strip() else "nan" for cell in cells)
        else:
            yield line
