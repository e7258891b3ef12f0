"""Pairs of files of Rohde & Schwarz oscilloscopes (RTO, RTE, RTP): a header, and its values.

`X.csv` has a property a line, `SignalResolution:1e-06:`; `X.Wfm.csv` has the values of a sample a
line, and no names. Properties: R&S RTO6 User Manual 1801.6687.02-05, tables 12-1 and following,
pages 453 to 458. A list begins with its length and may end with its unit.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from gmfbo.errors import RecordingError
from gmfbo.recordings.csv.header import is_number
from gmfbo.recordings.csv.layout import Layout
from gmfbo.recordings.csv.oscilloscope import EvenClock
from gmfbo.units import parse_unit

_VALUES = ".wfm.csv"
_PROPERTY = re.compile(r"\s*(?P<name>\w+):(?P<values>.*):?\s*")
_MOST_PROPERTIES = 400

Properties = Mapping[str, Sequence[str]]


def refuse_header(path: Path, lines: Sequence[str]) -> None:
    """Raise for the header of a pair.

    It is not read in place of its values: `*.csv` would give each recording twice.

    Parameters
    ----------
    path : Path
        File that was named.
    lines : sequence of str
        Of it.

    Raises
    ------
    RecordingError
        It is a header; names the file of its values.
    """
    if path.name.lower().endswith(_VALUES) or not _is_header(_properties(lines)):
        return
    raise RecordingError(
        f"{path.name}: expected a recording, got the header of a Rohde & Schwarz waveform; name "
        f"its values, '{path.stem}.Wfm.csv', and leave the header beside them"
    )


def header_of(path: Path) -> Properties | None:
    """Properties of the waveform in a file of values; None for other files.

    Parameters
    ----------
    path : Path
        `X.Wfm.csv`, beside which `X.csv` lies.
    """
    if not path.name.lower().endswith(_VALUES):
        return None
    stem = path.name[: -len(_VALUES)]
    for ending in (".csv", ".CSV"):
        header = path.with_name(stem + ending)
        if header.is_file():
            text = header.read_bytes()[:1_000_000].decode("utf-8-sig", errors="replace")
            properties = _properties(text.splitlines())
            return properties if _is_header(properties) else None
    return None


def refuse_without_header(path: Path, first: Sequence[str]) -> None:
    """Raise for values whose header is missing.

    Parameters
    ----------
    path : Path
        File without a header beside it.
    first : sequence of str
        Cells of its first line.

    Raises
    ------
    RecordingError
        It is `X.Wfm.csv` and begins with numbers: nothing tells their times.
    """
    if path.name.lower().endswith(_VALUES) and all(map(is_number, filter(str.strip, first))):
        raise RecordingError(
            f"{path.name}: values of a Rohde & Schwarz waveform without names and times: expected "
            f"its header '{path.name[: -len(_VALUES)]}.csv' beside it; copy both files"
        )


def layout_of_values(table: list[list[str]], properties: Properties, label: str) -> Layout:
    """Names, units, rows and clock of the values.

    Parameters
    ----------
    table : list of list of str
        Cells of each line of the values.
    properties : mapping of str to sequence of str
        From `header_of`.
    label : str
        File name, for messages.

    Raises
    ------
    RecordingError
        There are several acquisitions, or other columns than the header states.
    """
    rows = [_without_end(row) for row in table]
    acquisitions = _number(properties, "NumberOfAcquisitions") or 1.0
    if acquisitions > 1.0:
        raise RecordingError(
            f"{label}: expected one acquisition, got {acquisitions:g} one after the other; export "
            "a single one"
        )
    names = _names(properties)
    unit = _unit(properties)
    units = [unit] * len(names)
    width = len(rows[-1])
    if width == len(names) + 1:
        return Layout(["time", *names], ["s", *units], rows)
    if width != len(names):
        raise RecordingError(
            f"{label}: expected {len(names)} values a line ({', '.join(names)}), as its header "
            f"states, got {width}; export header and values together"
        )
    return Layout(names, units, rows, _clock(properties, len(rows)))


def _properties(lines: Sequence[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    if not lines or _PROPERTY.fullmatch(lines[0]) is None:
        return found  # the usual table
    for line in lines[:_MOST_PROPERTIES]:
        told = _PROPERTY.fullmatch(line)
        if told is not None:
            found.setdefault(told["name"], [v.strip() for v in told["values"].split(":")])
    return found


def _is_header(properties: Properties) -> bool:
    return _number(properties, "XStart") is not None and bool(_step(properties))


def _number(properties: Properties, name: str) -> float | None:
    values = properties.get(name) or [""]
    return float(values[0].replace(",", ".")) if is_number(values[0]) else None


def _step(properties: Properties) -> float:
    """Time between two samples [s]; the waveform's own comes first."""
    steps = (_number(properties, name) for name in ("SignalResolution", "Resolution"))
    return next((step for step in steps if step and step > 0.0), 0.0)


def _clock(properties: Properties, rows: int) -> EvenClock:
    """Clock of the values: files may hold samples before XStart, for filters."""
    start = _number(properties, "HardwareXStart")
    if start is None or _number(properties, "SignalHardwareRecordLength") != rows:
        start = _number(properties, "XStart")
    return EvenClock(start or 0.0, _step(properties))


def _names(properties: Properties) -> list[str]:
    """Channels in the order of the columns; an envelope has two columns for each."""
    named = [(properties.get("Source") or ["Ch1"])[0] or "Ch1"]
    if (properties.get("MultiChannelExport") or [""])[0].lower() == "on":
        states = properties.get("MultiChannelExportState", [])[1:]
        sources = properties.get("MultiChannelSource", [])[1:]
        on = [k for k, state in enumerate(states) if state.lower() == "on"]
        named = [sources[k] if k < len(sources) else f"Ch{k + 1}" for k in on] or named
    if _number(properties, "InterleavedTraceCount") == 2.0:
        return [f"{name} {end}" for name in named for end in ("min", "max")]
    return named


def _unit(properties: Properties) -> str:
    """Unit at the end of a list of offsets, where there is one."""
    for name in ("MultiChannelVerticalOffset", "VerticalOffset"):
        values = [value for value in properties.get(name, []) if value]
        if values and not is_number(values[-1]) and parse_unit(values[-1]) is not None:
            return values[-1]
    return ""


def _without_end(row: list[str]) -> list[str]:
    """A row without the empty cell behind a separator at its end."""
    return row[:-1] if len(row) > 1 and not row[-1].strip() else row
