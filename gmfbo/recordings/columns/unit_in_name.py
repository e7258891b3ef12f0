"""Units in a column's name: `position_deg`, `time/ms`, `Time in ms`, `phi(deg)`, `phi, deg`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
from gmfbo.recordings.columns.columns import CLOCK_NAMES, RecordedColumns
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.units import parse_unit

_IN = re.compile(r"(?P<name>.*\S)\s+(?:in|IN)\s+(?P<unit>\S.*)")
_BRACKETS = re.compile(r"(?P<name>[^()]*[^()\s])\((?P<unit>[^()]+)\)")
_BRACES = re.compile(r"(?P<name>[^{}]*[^{}\s])\s*\{(?P<unit>[^{}]+)\}")
_MARK = re.compile(r"(?P<name>.*[^\s,])(?:,|\s+-)\s+(?P<unit>\S.*)")  # `phi, deg` and `phi - deg`
_NAMELESS_CLOCK = re.compile(r"in\s+(?P<unit>\S+)")  # `in s` of Rohde & Schwarz oscilloscopes
_SLASH = re.compile(r"(?P<name>[^/]*[^/\s])\s*/\s*(?P<unit>.+)")

_OTHER_WORDS = ("in", "r", "U", "h", "d")
"""Units that are more often something else at the end of a name: an input, a direct axis."""

_MOST_PARTS = 4  # of a unit in a name: rad_per_s_2
_LONGEST_NAME = 200  # reading a name takes time by the square of its length


def names_and_units(text: str) -> Iterator[tuple[str, str]]:
    """Each way to read a column's name as a name and a known unit; the longest unit first.

    Parameters
    ----------
    text : str
        Name of the column; brackets after a blank were taken off with the header.
    """
    if len(text) > _LONGEST_NAME:
        return
    for form in (_IN, _SLASH, _BRACKETS, _BRACES, _MARK):
        found = form.fullmatch(text)
        if found:
            unit = found["unit"].strip()
            if parse_unit(unit) is not None:
                yield found["name"], unit
    parts = text.split("_")
    for first in range(max(1, len(parts) - _MOST_PARTS), len(parts)):
        name, tail = "_".join(parts[:first]), "_".join(parts[first:])
        if not name or tail in _OTHER_WORDS:
            continue
        tail = tail.replace("_per_", "/")
        for unit in dict.fromkeys(tail.replace("_", mark, 1) for mark in "/."):
            if parse_unit(unit) is not None:
                yield name, unit


def with_units_of_names(
    file: RecordedColumns, mapping: ColumnMapping, specs: Mapping[str, SignalSpec]
) -> ColumnMapping:
    """Add to a mapping what the names of columns say about signals and clock.

    A column serves a signal if its name is the signal's column, with a unit of the signal's
    quantity at its end. What the mapping, the twin file or brackets state comes first.

    Parameters
    ----------
    file : RecordedColumns
        As read.
    mapping : ColumnMapping
        Of the twin file.
    specs : mapping of str to SignalSpec
        Of the twin; empty without one.
    """
    if file.notes.own:
        return mapping
    units = {column.name: column.unit for column in file.columns}
    readings = [
        (column, base, unit)
        for column, stated in units.items()
        if not stated
        for base, unit in names_and_units(column)
    ]
    added = dict(mapping.columns)
    if "time" not in added and (clock := _clock(units, readings)) is not None:
        added["time"] = clock
    for name, spec in specs.items():
        given = added.get(name)
        if given is not None and (given.converts or given.column not in units):
            continue
        column = spec.column if given is None else given.column
        if column in units:
            unit = "" if units[column] or spec.scaled else _own_unit(column, spec)
            if unit:
                added[name] = MappedColumn(column, unit)
            continue
        alike = [
            (other, unit) for other, base, unit in readings if base == column and _fits(unit, spec)
        ]
        if len(alike) == 1:
            other, unit = alike[0]
            added[name] = MappedColumn(other, "" if spec.scaled else unit)
    return replace(mapping, columns=added)


def notes_on_units(
    file: RecordedColumns, mapping: ColumnMapping, read: ColumnMapping
) -> tuple[str, ...]:
    """Tell which units were read in names, and where twin file and header contradict each other.

    Parameters
    ----------
    file : RecordedColumns
        As read.
    mapping : ColumnMapping
        Of the twin file.
    read : ColumnMapping
        The same with what the names of columns say.
    """
    units = {column.name: column.unit for column in file.columns if not column.assumed}
    by_name = [
        f"{entry.column} as {name} [{entry.unit}]"
        for name, entry in read.columns.items()
        if entry.unit and entry != mapping.columns.get(name)
    ]
    notes = [f"{file.label}: read by name: {', '.join(by_name)}"] if by_name else []
    for name, entry in mapping.columns.items():
        header = units.get(entry.column, "")
        known = parse_unit(entry.unit), parse_unit(header)
        if None not in known and known[0] != known[1] and not file.notes.own:
            notes.append(
                f"{file.label}: the header of {entry.column} says [{header}], [columns] of the "
                f"twin file says {entry.unit} for {name}, which counts; leave unit out there if "
                "the header is right"
            )
    return tuple(notes)


def note_on_header(notes: Sequence[str], signal: str) -> str:
    """Note that a header contradicts the twin file's unit for a signal; empty where none does.

    Parameters
    ----------
    notes : sequence of str
        Of a recording.
    signal : str
        The user's name.
    """
    return next((note for note in notes if f" for {signal}, which counts;" in note), "")


def _clock(
    units: Mapping[str, str], readings: Sequence[tuple[str, str, str]]
) -> MappedColumn | None:
    """Clock whose name ends in a unit of time; None where a column has a clock's plain name."""
    if any(_is_clock(name) for name in units):
        return None
    for column, base, unit in readings:
        known = parse_unit(unit)
        if _is_clock(base) and known is not None and known.si == "s":
            return MappedColumn(column, unit)
    first = next(iter(units), "")
    for column, base, unit in readings:
        known = parse_unit(unit)
        if column == first and known is not None and known.si == "s" and _speaks_of_time(base):
            return MappedColumn(column, unit)
    nameless = _NAMELESS_CLOCK.fullmatch(first)
    known = parse_unit(nameless["unit"]) if nameless else None
    if nameless and known is not None and known.si == "s":
        return MappedColumn(first, nameless["unit"])
    return None


def _speaks_of_time(name: str) -> bool:
    """Whether a clock's name is one of its words: `Elapsed time`, `rel_time`."""
    return not set(re.split(r"[\W_]+", name.lower())).isdisjoint(set(CLOCK_NAMES) - {"t"})


def _is_clock(name: str) -> bool:
    return name == "t" or (name.lower() in CLOCK_NAMES and name != "T")


def _own_unit(column: str, spec: SignalSpec) -> str:
    """Unit at the end of a name that the twin file gives, if it is one of the signal's quantity."""
    if not spec.unit:
        return ""
    return next((unit for _, unit in names_and_units(column) if _fits(unit, spec)), "")


def _fits(unit: str, spec: SignalSpec) -> bool:
    known, target = parse_unit(unit), parse_unit(spec.unit) if spec.unit else None
    if known is None or known.needs_scale:
        return False
    return target is None or known.dimension == target.dimension
