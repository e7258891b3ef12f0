"""Find where the table of a text file begins, below a logger's or spreadsheet's preamble."""

from __future__ import annotations

import re

from gmfbo.recordings.csv.header import is_number, read_units_row
from gmfbo.recordings.csv.times import is_time

_SEPARATOR = re.compile(r'"?sep=(?P<mark>[;,\t])"?', re.IGNORECASE)
_LOOKED_AT = 200
"""Most lines above a header; no logger writes more."""


def stated_delimiter(line: str) -> str:
    """Delimiter stated by a spreadsheet's first line, such as `sep=;`; empty for other lines."""
    found = _SEPARATOR.fullmatch(line.strip())
    return found["mark"] if found else ""


def header_row(table: list[list[str]]) -> int:
    """Row of the header: the first row of words with numbers below it.

    Parameters
    ----------
    table : list of list of str
        Cells of each line that is not blank.

    Returns
    -------
    int
        0 where no row looks like a header, so that messages name the file's first line.
    """
    width = len(next((row for row in reversed(table) if any(map(is_number, row))), table[0]))
    for k, row in enumerate(table[:_LOOKED_AT]):
        if _is_header(row, width) and _has_numbers_below(table[k + 1 : k + 5]):
            return k
    return 0


def _is_header(row: list[str], width: int) -> bool:
    named = [cell for cell in row if cell.strip()]
    # The name of a row number, or one after a delimiter at the end, may be blank.
    return len(named) >= max(width - 1, 1) and not any(map(is_number, named))


def _has_numbers_below(rows: list[list[str]]) -> bool:
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    if rows and read_units_row(rows[0]) is not None:
        rows = rows[1:]
    return bool(rows) and all(
        any(is_number(cell) or is_time(cell.strip()) for cell in row) for row in rows[:3]
    )
