"""Find where the table of a text file begins, below a logger's or spreadsheet's preamble."""

from __future__ import annotations

import re

from gmfbo.recordings.columns.columns import CLOCK_NAMES
from gmfbo.recordings.csv.header import is_number, read_units_row, split_unit
from gmfbo.recordings.csv.times import is_time

_SEPARATOR = re.compile(r'"?sep=(?P<mark>[;,\t])"?', re.IGNORECASE)
_LOOKED_AT = 200
"""Most lines above a header; no logger writes more."""

_MOST_BETWEEN = 3
"""Most rows of units and labels between the names and the numbers."""


def stated_delimiter(line: str) -> str:
    """Delimiter stated by a spreadsheet's first line, such as `sep=;`; empty for other lines."""
    found = _SEPARATOR.fullmatch(line.strip())
    return found["mark"] if found else ""


def header_row(table: list[list[str]]) -> int | None:
    """Row of the names of the columns: above a row of numbers, units and labels between.

    Parameters
    ----------
    table : list of list of str
        Cells of each line that is not blank.

    Returns
    -------
    int or None
        None where no row looks like a header.
    """
    last = next((row for row in reversed(table) if any(map(is_number, row))), table[0])
    width = len(last)
    numbers = next((k for k, cell in enumerate(last) if is_number(cell)), 0)
    for k, row in enumerate(table[:_LOOKED_AT]):
        if _is_header(row, width) and _has_numbers_below(table[k + 1 : k + 5], numbers):
            return _names_among(table, k, width)
    return None


def rows_between(table: list[list[str]], header: int) -> int:
    """Rows of units and labels between the header and the first row of numbers.

    Parameters
    ----------
    table : list of list of str
        Cells of each line that is not blank.
    header : int
        Row of the names.
    """
    between = 0
    for row in table[header + 1 : header + 1 + _MOST_BETWEEN]:
        if _has_value(row) or not any(cell.strip() for cell in row):
            break
        between += 1
    below = table[header + 1 + between : header + 2 + between]
    if not below or not _has_value(below[0]):
        return 1 if between and read_units_row(table[header + 1]) is not None else 0
    return between


def _names_among(table: list[list[str]], lowest: int, width: int) -> int:
    """Row of names in a block of rows of words, whose lowest row stands above the numbers.

    The one that names the clock, else the last above a row of units, else the lowest.
    """
    top = lowest
    while top > max(lowest - _MOST_BETWEEN, 0) and _is_header(table[top - 1], width):
        top -= 1
    units = [k for k in range(top, lowest + 1) if read_units_row(table[k]) is not None]
    names = [k for k in range(top, lowest + 1) if k not in units]
    for k in names:
        if any(split_unit(cell)[0].lower() in CLOCK_NAMES for cell in table[k]):
            return k
    above = [k for k in names if units and k < units[0]]
    return above[-1] if above else lowest


def _has_value(row: list[str]) -> bool:
    return any(is_number(cell) or is_time(cell.strip()) for cell in row)


def _is_header(row: list[str], width: int) -> bool:
    named = [cell for cell in row if cell.strip()]
    # The name of a row number, or one after a delimiter at the end, may be blank.
    return len(named) >= max(width - 1, 1) and not any(map(is_number, named))


def _has_numbers_below(rows: list[list[str]], place: int) -> bool:
    """Whether rows follow that have a number, and no word in the first place of numbers."""
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    # Oscilloscopes put start and increment into their row of units.
    if rows and read_units_row(["" if is_number(c) else c for c in rows[0]]) is not None:
        rows = rows[1:]
    return bool(rows) and all(_has_value(row) and _no_word(row, place) for row in rows[:3])


def _no_word(row: list[str], place: int) -> bool:
    cell = row[place].strip() if place < len(row) else ""
    return not cell or is_number(cell) or is_time(cell)
