"""Tables of oscilloscopes: times by start and increment, and labels beside the numbers.

Rigol states `Start` and `Increment`, or `t0 =` and `tInc =`, in the header of the table; Keysight
writes `XOrg` and `XInc` above it; older Tektronix instruments write their labels in the three
columns left of time and value, again for each channel.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gmfbo.recordings.csv.header import is_number
from gmfbo.units import parse_unit

_START = {"start", "xorg", "xorigin", "xstart", "x0", "t0"}
_STEP = {
    "increment", "xinc", "xincrement", "deltax", "tinc", "dt",
    "sampleinterval", "samplinginterval", "sampleperiod", "samplingperiod",
}  # fmt: skip
_STATED = re.compile(r"\s*(?P<key>t0|tInc)\s*=\s*(?P<value>[-+0-9.eE]+)\s*", re.IGNORECASE)
_WITHOUT_GAP = re.compile(r"(?P<name>[^()\[\]]*\S)\((?P<unit>[^()]+)\)")
_LABELS, _TIME, _VALUE = 3, 3, 4  # columns of one channel of a Tektronix file
_MOST_LABELS = 40


@dataclass(frozen=True)
class EvenClock:
    """Instants of a table without a column of times: start + step * row.

    Attributes
    ----------
    start, step : float
        [s]
    """

    start: float
    step: float


def labels_beside(table: list[list[str]]) -> list[list[str]] | None:
    """Header, units and rows of a Tektronix file; None for others.

    Parameters
    ----------
    table : list of list of str
        Cells of each line that is not blank.
    """
    first = table[0]
    starts = [k for k, cell in enumerate(first) if _key(cell) == "recordlength"]
    if not starts or starts[0] != 0:
        return None
    if any(len(first) <= k + _VALUE or not is_number(first[k + _TIME]) for k in starts):
        return None
    header, units, places = ["time"], ["s"], [_TIME]
    for k in starts:
        labels = {
            _key(row[k]): row[k + 1].strip() for row in table[:_MOST_LABELS] if len(row) > k + 1
        }
        header.append(labels.get("source") or f"column {k + _VALUE + 1}")
        unit = labels.get("verticalunits", "")
        units.append(unit if parse_unit(unit) is not None else "")
        places.append(k + _VALUE)
    rows = [[row[p] if p < len(row) else "" for p in places] for row in table]
    return [header, units, *rows]


def stated_in_header(
    header: list[str], below: list[str]
) -> tuple[EvenClock, Callable[[list[str]], list[str]]] | None:
    """Start and increment that a header states, and what a line keeps without them.

    Parameters
    ----------
    header : list of str
        Cells of the header.
    below : list of str
        Cells of the line below, which holds the values of `Start` and `Increment`.

    Returns
    -------
    tuple or None
        The clock, and a function that leaves its cells out of a line.
    """
    found: dict[str, float] = {}
    out = set()
    for k, cell in enumerate(header):
        stated = _STATED.fullmatch(cell)
        value = below[k].strip() if k < len(below) else ""
        if stated and is_number(stated["value"]):
            found["start" if stated["key"].lower() == "t0" else "step"] = float(stated["value"])
            out.add(k)
        elif _key(cell) in ("start", "increment") and is_number(value):
            found["start" if _key(cell) == "start" else "step"] = float(value)
            out.add(k)
    if not found.get("step", 0.0) > 0.0:
        return None
    kept = [k for k in range(len(header)) if k not in out]
    return EvenClock(found.get("start", 0.0), found["step"]), lambda row: [
        row[k] for k in kept if k < len(row)
    ]


def stated_above(lines: Sequence[Sequence[str]]) -> EvenClock | None:
    """Start and increment in the lines above a table, `XInc, 1e-3` or `Sample Interval: 1 ms`.

    Parameters
    ----------
    lines : sequence of sequence of str
        Cells of these lines.
    """
    start, step = 0.0, 0.0
    for cells in lines:
        words = [word.strip() for cell in cells for word in cell.split(":")]
        words = [word for word in words if word]
        if len(words) < 2:
            continue
        value = _seconds(words[1], words[2] if len(words) > 2 else "")
        if value is None:
            continue
        if _key(words[0]) in _START:
            start = value
        elif _key(words[0]) in _STEP and value > 0.0:
            step = step or value
    return EvenClock(start, step) if step else None


def channels_named(table: list[list[str]]) -> list[list[str]]:
    """`x-axis,1,2` of Keysight as `x-axis,CH1,CH2`: bare numbers would be no header."""
    first, *rows = table
    if _key(first[0]) != "xaxis" or not any(cell.strip().isdecimal() for cell in first[1:]):
        return table
    named = [f"CH{cell.strip()}" if cell.strip().isdecimal() else cell for cell in first[1:]]
    return [[first[0], *named], *rows]


def with_gap(cell: str) -> str:
    """`Time(s)` as `Time (s)`, in headers of which no name is that of a function."""
    found = _WITHOUT_GAP.fullmatch(cell.strip())
    if found and parse_unit(found["unit"]) is not None:
        return f"{found['name']} ({found['unit']})"
    return cell


def _seconds(text: str, unit: str) -> float | None:
    number, _, own = text.partition(" ")
    known = parse_unit(own.strip() or (unit if parse_unit(unit) is not None else "") or "s")
    if not is_number(number) or known is None or known.si != "s":
        return None
    value = float(number.replace(",", ".")) * float(known.factor)
    return value if abs(value) < float("inf") else None


def _key(cell: str) -> str:
    return re.sub(r"[\s_\-]", "", cell).rstrip(":").lower()
