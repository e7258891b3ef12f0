"""Names and units in the header of a CSV recording."""

from __future__ import annotations

import re
from collections import Counter

from gmfbo.errors import RecordingError
from gmfbo.units import parse_unit

# Words of oscilloscopes for units, in rows of units only; further spellings are in gmfbo.units.
_WORDS = {
    "second": "s", "seconds": "s", "sec": "s", "millisecond": "ms", "microsecond": "us",
    "volt": "V", "volts": "V", "ampere": "A", "amperes": "A", "amp": "A", "amps": "A",
    "watt": "W", "watts": "W", "degree": "deg", "degrees": "deg", "hertz": "Hz",
    "radian": "rad", "radians": "rad", "ohm": "Ohm",
}  # fmt: skip
_NO_UNIT = {"sequence", "unknown", "none", "unit", "units"}
# `x[1,2]` is an element of an array, `x [1]`, `x [N.m]` and `x[N.m]` carry a unit.
_BRACKETS = re.compile(r"(?P<name>.*?)(?P<gap>\s*)\[(?P<unit>[^\[\]]*)\]")
_PARENTHESES = re.compile(r"(?P<name>.*\S)\s+\((?P<unit>.+)\)")
_INDEX = re.compile(r"[\d,\s]*")


def split_unit(cell: str) -> tuple[str, str]:
    """Name and unit of a header cell; the unit is empty where there is none."""
    cell = cell.strip()
    found = _BRACKETS.fullmatch(cell)
    if found and (found["gap"] or not _INDEX.fullmatch(found["unit"])):
        return found["name"], found["unit"].strip()
    found = _PARENTHESES.fullmatch(cell)
    if found and parse_unit(found["unit"]) is not None:
        return found["name"], found["unit"].strip()
    return cell, ""


def header_cell(name: str, unit: str) -> str:
    """Cell for the header, quoted where a reader would otherwise split it.

    Raises
    ------
    RecordingError
        The name would not be read back unchanged.
    """
    cell = f"{name} [{unit}]" if unit else name
    if split_unit(cell) != (name, unit) or not name or re.search(r"[\r\n]", cell):
        raise RecordingError(
            f"signal '{name}' [{unit}] cannot be written into a CSV header, from which it could "
            "not be read back; rename it, or write .h5 instead"
        )
    return '"' + cell.replace('"', '""') + '"' if re.search(r'[,;\t"]', cell) else cell


def read_header(cells: list[str], label: str) -> tuple[list[str], list[str]]:
    """Names and units of all columns.

    Raises
    ------
    RecordingError
        The line holds numbers.
    """
    names, units = [], []
    for index, cell in enumerate(cells):
        name, unit = split_unit(cell)
        # Spreadsheets and data frames leave the name of a row-number column blank.
        names.append(name or f"column {index + 1}")
        units.append(unit)
    if all(is_number(cell) for cell in cells if cell.strip()):
        raise RecordingError(
            f"{label}: expected a header such as 'time [s],position [rad]', got numbers; add a "
            "line with the names of the columns"
        )
    return _each_once(names), units


def _each_once(names: list[str]) -> list[str]:
    """Number equal names: `pos (1)`, `pos (2)`; whoever needs `pos` has to say which."""
    total, seen = Counter(names), Counter[str]()
    told = []
    for name in names:
        seen[name] += 1
        numbered = name if total[name] == 1 else f"{name} ({seen[name]})"
        while numbered in told or (numbered != name and numbered in total):
            numbered += "'"  # the file itself has a column of that name
        told.append(numbered)
    return told


def read_units_row(cells: list[str]) -> list[str] | None:
    """Units in the row below the header; None where that is no row of units."""
    bare = [_bare(cell) for cell in cells]
    if is_number(bare[0]) or all(is_number(cell) for cell in bare if cell):
        return None
    units = [_unit(cell) for cell in bare]
    if any(unit is None for unit in units) or not any(units):
        return None
    return [unit or "" for unit in units]


def _unit(cell: str) -> str | None:
    """Unit of a cell of a row of units, empty for none; None where the cell is something else."""
    word = cell.lower()
    if not cell or word in _NO_UNIT:
        return ""
    unit = _WORDS.get(word, cell)
    return unit if parse_unit(unit) is not None else None


def _bare(cell: str) -> str:
    cell = cell.strip()
    pairs = {"[": "]", "(": ")"}
    return cell[1:-1].strip() if cell and pairs.get(cell[0]) == cell[-1] else cell


def is_number(cell: str) -> bool:
    """Whether a cell of text is a number, with a point or a comma."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
