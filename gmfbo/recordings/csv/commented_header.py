"""A header behind a comment sign, as `numpy.savetxt` and many loggers write it."""

from __future__ import annotations

import re

from gmfbo.recordings.csv.cells import cells_of, separator_of_table
from gmfbo.recordings.csv.header import is_number
from gmfbo.recordings.csv.times import is_time

_SIGN = "#"
_MATLAB = "%"
_MOST = 3  # names, units, and a line of explanations


def is_comment(line: str) -> bool:
    """Whether a line begins with the comment sign `#`."""
    return line.lstrip().startswith(_SIGN)


def with_bare_header(lines: list[str]) -> list[str]:
    """Lines without the comment sign in front of the header, where the table itself has none.

    Parameters
    ----------
    lines : list of str
        Of the whole file.

    Returns
    -------
    list of str
        As many lines; unchanged where the first line of the table is no row of numbers, or no
        comment right above it has as many cells as that row.
    """
    lines = _with_one_sign(lines)
    top = next((line for line in lines if line.strip()), "")
    if not is_comment(top):
        return lines  # the usual table, whose lines are not looked at one by one
    places = [k for k, line in enumerate(lines) if line.strip() and not is_comment(line)]
    if not places:
        return lines
    separator = separator_of_table([lines[k] for k in places])
    first = cells_of([lines[places[0]]], separator, "")[0]
    while first and not first[-1].strip():
        first = first[:-1]
    if not first or not all(_is_value(cell) for cell in first):
        return lines
    bare = list(lines)
    for k in range(places[0] - 1, max(places[0] - 1 - _MOST, -1), -1):
        text = lines[k].strip().lstrip(_SIGN).strip()
        if not is_comment(lines[k]) or "=" in text:
            break
        if text.count('"') % 2:
            break
        # The last line tells how many cells set apart by blanks a line has.
        cells = cells_of([text, lines[places[0]].strip()], separator, "")[0]
        while cells and not cells[-1].strip():
            cells = cells[:-1]
        if len(cells) == 1:
            cells = text.split()  # names set apart by blanks above rows that are not
        if len(cells) != len(first) or any(map(is_number, cells)):
            break
        bare[k] = text
    return bare


def _with_one_sign(lines: list[str]) -> list[str]:
    """Lines with `#` for the `%` of lines above numbers; a name such as `%PWM` stays a name."""
    count = 0
    while count < len(lines) and (not lines[count].strip() or _is_matlab(lines[count])):
        count += 1
    below = lines[count].split() if count < len(lines) else []
    if not below or not is_number(re.split(r"[;,]", below[0])[0]):
        return lines
    top = [line.replace(_MATLAB, _SIGN, 1) if _is_matlab(line) else line for line in lines[:count]]
    return [*top, *lines[count:]] if any(map(_is_matlab, lines[:count])) else lines


def _is_matlab(line: str) -> bool:
    return line.lstrip().startswith(_MATLAB) and re.match(r"\s*%[%\s]", line) is not None


def _is_value(cell: str) -> bool:
    cell = cell.strip()
    return not cell or is_number(cell) or is_time(cell)
