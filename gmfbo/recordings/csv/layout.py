"""Layout of a text table: its names, its units, its rows, and a clock that its header states."""

from __future__ import annotations

from dataclasses import dataclass

from gmfbo.recordings.csv.header import is_number, read_header, read_units_row
from gmfbo.recordings.csv.oscilloscope import (
    EvenClock,
    channels_named,
    labels_beside,
    stated_above,
    stated_in_header,
    with_gap,
)
from gmfbo.recordings.csv.preamble import header_row, rows_between
from gmfbo.recordings.csv.times import is_time


@dataclass(frozen=True)
class Layout:
    """Parts of a text table.

    Attributes
    ----------
    names, units : list of str
        Of each column.
    rows : list of list of str
        Cells of the lines below, the last lines of the file.
    clock : EvenClock or None
        Start and increment that stand in the header, for a table without a column of times.
    sequence : bool
        Whether the first column counts the samples of that clock.
    """

    names: list[str]
    units: list[str]
    rows: list[list[str]]
    clock: EvenClock | None = None
    sequence: bool = False


def layout_of(table: list[list[str]], label: str, *, own: bool) -> Layout:
    """Find the parts of a table.

    Parameters
    ----------
    table : list of list of str
        Cells of each line that is not blank and no comment.
    label : str
        File name, for messages.
    own : bool
        Whether gmfbo wrote the file: then the first line is its header.

    Raises
    ------
    RecordingError
        A file of ours has numbers in place of its header.
    """
    if own:
        return _below_header(table, 0, label)
    if (moved := labels_beside(table)) is not None:
        header, units, *rows = moved
        return Layout(read_header(header, label)[0], units, rows)
    table = channels_named(table)
    row = header_row(table)
    if row is None and (first := _first_of_bare_numbers(table)) is not None:
        return _without_header(table, first)
    return _below_header(table, row or 0, label)


def _first_of_bare_numbers(table: list[list[str]]) -> int | None:
    """First row of a table of numbers that has no header; None where its last row is none."""
    first = len(table)
    while first and _is_all_values(table[first - 1]):
        first -= 1
    return first if first < len(table) else None


def _without_header(table: list[list[str]], first: int) -> Layout:
    """Columns by their places: `column 1`, `column 2`."""
    rows = table[first:]
    width = max(map(len, rows))
    while width > 1 and not any("".join(row[width - 1 :]).strip() for row in rows):
        width -= 1  # a separator ends each line
    names = [f"column {k + 1}" for k in range(width)]
    return Layout(names, [""] * width, rows, stated_above(table[:first]))


def _below_header(table: list[list[str]], row: int, label: str) -> Layout:
    header, rows = table[row], table[row + 1 :]
    below = rows[0] if rows else []
    clock, sequence = None, False
    if (stated := stated_in_header(header, below)) is not None:
        clock, without = stated
        sequence = bool(below) and below[0].strip().lower() == "sequence"
        header, rows = [with_gap(cell) for cell in without(header)], [without(r) for r in rows]
    if (
        len(header) > 1
        and not header[-1].strip()
        and not any("".join(r[len(header) - 1 :]).strip() for r in rows)
    ):
        header = header[:-1]  # a separator ends each line
    names, units = read_header(header, label)
    between = rows_between([header, *rows], 0)
    given = [read_units_row(cells) for cells in rows[:between]]
    for found in [units_row for units_row in given if units_row is not None][:1]:
        found = found + [""] * (len(units) - len(found))
        units = [unit or other for unit, other in zip(units, found, strict=False)]
    clock = clock or stated_above(table[:row])
    return Layout(names, units, rows[between:], clock, sequence)


def _is_all_values(row: list[str]) -> bool:
    filled = [cell.strip() for cell in row if cell.strip()]
    return bool(filled) and all(is_number(cell) or is_time(cell) for cell in filled)
