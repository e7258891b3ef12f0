"""Cells of lines of text: what stands between them, and lines set apart by blanks."""

from __future__ import annotations

import csv
import re

from gmfbo.errors import RecordingError
from gmfbo.recordings.csv.header import is_number, split_unit
from gmfbo.recordings.csv.times import is_time, read_date

BLANKS = " "
"""The separator of a table whose cells are set apart by one or more blanks."""

_QUOTED = re.compile(r'"[^"]*"')
_ANY_MARK = re.compile(r"[;\s]")
_LOOKED_AT = 20
_WIDE_GAP = re.compile(r"\s{2,}|\t")


def separator_of_header(header: str) -> str:
    """Separator of one line: `;`, tab or comma, the first of them that it holds."""
    bare = _QUOTED.sub("", header)
    return next((mark for mark in (";", "\t", ",") if mark in bare), ",")


def separator_of_table(lines: list[str]) -> str:
    """Separator on which the last rows agree; lines above the table may have another or none.

    Parameters
    ----------
    lines : list of str
        Lines that are not blank, at least one.

    Returns
    -------
    str
        `;`, tab, comma or `BLANKS`.
    """
    tail = [_QUOTED.sub("", line) for line in lines[-_LOOKED_AT:]]
    # Of a short file the first of them may be its header.
    while len(tail) > 1 and not _begins_a_row(_ANY_MARK.split(tail[0].strip())[0]):
        tail = tail[1:]
    for mark in (";", "\t"):
        if all(mark in line for line in tail):
            return mark
    if _set_apart_by_blanks(lines):
        return BLANKS
    return separator_of_header(lines[0])


def cells_of(lines: list[str], separator: str, label: str) -> list[list[str]]:
    """Cells of each line; a cell must not span lines.

    Parameters
    ----------
    lines : list of str
        Of the table and what stands above it.
    separator : str
        From `separator_of_table`.
    label : str
        File name, for the message.

    Raises
    ------
    RecordingError
        A quotation mark is not closed.
    """
    if separator == BLANKS:
        width = len(lines[-1].split())
        return [_blank_cells(line, width) for line in lines]
    try:
        table = list(csv.reader(lines, delimiter=separator))
    except csv.Error:  # a cell beyond the module's limit of size
        table = []
    if len(table) != len(lines):
        raise RecordingError(f"{label}: a quotation mark is not closed; correct the file")
    width = len(table[-1]) if table else 0
    if width > 1 and len(table[0]) == 1 and '"' not in lines[0]:
        names = _blank_cells(lines[0], width)
        if len(names) == width and not any(map(is_number, names)):
            table[0] = names  # set apart by blanks, above rows that are not
    return table


def _set_apart_by_blanks(lines: list[str]) -> bool:
    """Whether the last rows are numbers with blanks between, and no other separator fits them."""
    tail = lines[-_LOOKED_AT:]
    # Of a short file the first lines may be its header and its units.
    while len(tail) > 1 and not _begins_a_row(tail[0].split()[0]):
        tail = tail[1:]
    rows = [line.split() for line in tail]
    if len(rows[-1]) < 2 or any(";" in line for line in tail):
        return False
    if not all(len(row) == len(rows[-1]) and _begins_a_row(row[0]) for row in rows):
        return False
    if not any("," in line for line in tail):
        return all(any(map(is_number, row)) for row in rows)
    # 1, 2 has commas between its cells; 1,5 2,5 has decimal commas.
    by_comma = [line.split(",") for line in tail]
    return all(all(map(is_number, row)) for row in rows) and not all(
        all(is_number(cell) for cell in row if cell.strip()) for row in by_comma
    )


def _begins_a_row(cell: str) -> bool:
    return is_number(cell) or is_time(cell) or bool(read_date(cell))


def _blank_cells(line: str, width: int) -> list[str]:
    """Cells of a line; names of several words, `position [rad]`, are joined where they must be."""
    cells = line.split()
    if len(cells) == width:
        return cells
    wide = [cell for cell in _WIDE_GAP.split(line.strip()) if cell]
    if len(wide) == width:
        return wide
    joined: list[str] = []
    for cell in cells:
        if joined and split_unit(f"{joined[-1]} {cell}")[1]:
            joined[-1] += f" {cell}"
        else:
            joined.append(cell)
    return joined if len(joined) == width else cells
