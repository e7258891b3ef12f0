"""Measurement files of LabVIEW (.lvm): a header, then segments of channels.

Format: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)". The package
lvm_read reads it too, but turns each cell that is no number into NaN without a word.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import FileNotes
from gmfbo.recordings.csv.times import read_times

_TITLE = "LabVIEW Measurement"
_END = "***End_of_Header***"
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}


@dataclass
class _Segment:
    """Lines of one segment: properties of its channels, names, and rows with their lines."""

    properties: dict[str, list[str]] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    rows: list[tuple[int, list[str]]] = field(default_factory=list)

    def numbers(self, key: str, count: int, otherwise: float) -> list[float]:
        """A property of each channel; a channel without one has that of the channel before."""
        known = otherwise
        found = []
        for k in range(count):
            cells = self.properties.get(key, [])
            value = _number(cells[k]) if k < len(cells) else None
            known = known if value is None else value
            found.append(known)
        return found


def is_lvm(lines: Sequence[str]) -> bool:
    """Whether text is a measurement file of LabVIEW."""
    return next((line for line in lines if line.strip()), "").startswith(_TITLE)


def read_lvm(lines: Sequence[str], label: str) -> RecordedChannels:
    """Read all channels, each with its clock; segments of one channel follow each other.

    Parameters
    ----------
    lines : sequence of str
        Of the whole file.
    label : str
        File name, for messages.

    Raises
    ------
    RecordingError
        There is no segment with rows.
    """
    separator = _separator(lines)
    table = [[cell.strip() for cell in line.split(separator)] for line in lines]
    ends = [k for k, cells in enumerate(table) if cells[0] == _END]
    top = table[: ends[0]] if ends else table
    stated = {cells[0]: cells[1] for cells in top if len(cells) > 1}
    segments = _segments(table, ends[0] + 1 if ends else 0)
    if not any(segment.rows for segment in segments):
        raise RecordingError(
            f"{label}: expected a segment with a line 'X_Value' and rows, got none; record again"
        )
    columns = stated.get("X_Columns", "One").lower()
    channels: dict[str, Channel] = {}
    for segment in segments:
        for channel in _channels(label, segment, columns):
            known = channels.get(channel.name)
            channels[channel.name] = channel if known is None else _joined(known, channel)
    start = _start(stated.get("Date", ""), stated.get("Time", ""))
    return RecordedChannels(label, tuple(channels.values()), notes=FileNotes(start_time=start))


def _separator(lines: Sequence[str]) -> str:
    for line in lines[:40]:
        if line.startswith("Separator"):
            word = line.removeprefix("Separator").strip().lower()
            return _SEPARATORS.get(word, word[:1] or "\t")
    return "\t"


def _segments(table: list[list[str]], first: int) -> list[_Segment]:
    segments = [_Segment()]
    for number, cells in enumerate(table[first:], start=first + 1):
        segment = segments[-1]
        if not any(cells):
            continue
        if segment.names and cells[0] in ("Channels", "Samples") and len(cells) > 1:
            segments.append(segment := _Segment())
        if cells[0] == "X_Value":
            segment.names = cells
        elif segment.names:
            segment.rows.append((number, cells))
        elif cells[0] != _END:
            segment.properties[cells[0]] = cells[1:]
    return segments


def _channels(label: str, segment: _Segment, columns: str) -> list[Channel]:
    """Channels of a segment; `columns` is No, One or Multi, for its columns of times."""
    width = 2 if columns == "multi" else 1
    places = [
        k
        for k, name in enumerate(segment.names)
        if name not in ("X_Value", "Comment", "") and (columns != "multi" or k % 2)
    ]
    starts = segment.numbers("X0", len(places), 0.0)
    steps = segment.numbers("Delta_X", len(places), 1.0)
    units = segment.properties.get("Y_Unit_Label", [])
    found = []
    for k, place in enumerate(places):
        values, fault = _values(label, segment, place)
        time = starts[k] + steps[k] * np.arange(values.size, dtype=np.float64)
        if columns != "no":
            stated, clock_fault = _values(label, segment, place - 1 if width == 2 else 0)
            time, fault = (time, fault or clock_fault) if clock_fault else (stated, fault)
        kept = np.isfinite(time)
        unit = units[k] if k < len(units) else ""
        name = segment.names[place]
        found.append(Channel(name, time[kept], values[kept], unit, "", "", fault))
    return found


def _values(label: str, segment: _Segment, place: int) -> tuple[NDArray[np.float64], str]:
    values = np.full(len(segment.rows), np.nan)
    for k, (number, cells) in enumerate(segment.rows):
        text = cells[place] if place < len(cells) else ""
        value = _number(text)
        if value is not None:
            values[k] = value
        elif text and text.lower() != "nan":
            return values, (
                f"{label}, line {number}, channel '{segment.names[place]}': expected a number, "
                f"got '{text}'; correct the cell, or leave it blank if not sampled"
            )
    return values, ""


def _joined(first: Channel, then: Channel) -> Channel:
    """A channel of which two segments hold a part; the second begins where the first ends."""
    time = then.time
    if first.time.size and time.size and time[0] <= first.time[-1]:
        # Each segment may count its time from its own beginning.
        step = float(np.median(np.diff(first.time))) if first.time.size > 1 else 0.0
        time = time - time[0] + first.time[-1] + step
    return Channel(
        first.name,
        np.concatenate([first.time, time]),
        np.concatenate([first.values, then.values]),
        first.unit,
        "",
        "",
        first.fault or then.fault,
    )


def _start(date: str, time: str) -> str:
    # LabVIEW writes more decimals than a picosecond.
    read = read_times([f"{date} {time[:15]}".strip()])
    return read[1] if read else ""


def _number(text: str) -> float | None:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return None if "_" in text or not np.isfinite(value) else value
