"""Text files that TwinCAT Scope exports: a block of headers, then groups with a clock each.

The block names the export, then each line repeats its key (`Name`, `SymbolName`, `Unit`) in front
of every group of columns; below, that place holds the group's time. Format: Beckhoff Information
System, TE13xx TC3 Scope View, "Export to CSV", and TwinCAT 2 Scope.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import FileNotes

_KEYS = {
    "Name", "SymbolComment", "Data-Type", "SampleTime[ms]", "VariableSize", "SymbolBased",
    "IndexGroup", "IndexOffset", "SymbolName", "NetID", "NetId", "Port", "Offset", "ScaleFactor",
    "BitMask", "Unit", "Unit ScaleFactor", "Unit Offset",
}  # fmt: skip
_START = ("Starttime of export", "StartRecord", "StartTime")
_HEAD = (*_START, "File", "Endtime of export", "EndRecord", "EndTime")
_FILETIME_PER_S = 10**7
_FILETIME_FROM = 10**15  # ticks of 100 ns since 1601; an export's milliseconds are never as large

_FILETIME_DIGITS = 18  # to the year 4770; more would not fit into 64 bits


def is_scope_export(lines: list[str], delimiter: str) -> bool:
    """Whether text was exported by TwinCAT Scope."""
    keys = [line.split(delimiter)[0].strip().strip('"') for line in lines[:80] if line.strip()]
    if not keys or keys[0] != "Name":
        return False
    return bool(set(keys[1:]) & {*_KEYS, *_HEAD}) or (len(keys) > 1 and _is_number(keys[1]))


def read_scope(lines: list[str], delimiter: str, label: str) -> RecordedChannels:
    """Read the channels of an export of TwinCAT Scope.

    A group's samples are the rows in which its time changes: slower groups end early, are blank
    between their samples, or repeat the last one, as the export was configured.

    Raises
    ------
    RecordingError
        There is no line `Name` with the channels, or a cell is no number; names the line.
    """
    table = [[cell.strip().strip('"') for cell in line.split(delimiter)] for line in lines]
    rows = [k for k, cells in enumerate(table) if cells[0] in _KEYS]
    if not rows:
        raise RecordingError(
            f"{label}: expected a TwinCAT Scope export with a line that begins with 'Name', got "
            "none; export it with its header, or choose another dialect"
        )
    # The export's own name stands above that of the channels.
    first = max([k for k in rows if table[k][0] == "Name"] or rows[:1])
    headers = {table[k][0]: table[k] for k in rows if k >= first}
    body = [k for k in range(max(rows) + 1, len(table)) if any(table[k]) and table[k][0] != "EOF"]
    return RecordedChannels(
        label=label,
        channels=tuple(_channels(label, headers, table[first], [(k, table[k]) for k in body])),
        notes=FileNotes(start_time=_start_time(table[:first])),
    )


def _channels(
    label: str, headers: dict[str, list[str]], names: list[str], body: list[tuple[int, list[str]]]
) -> list[Channel]:
    channels: list[Channel] = []
    for place, name in enumerate(names):
        if name == names[0]:
            rows, time = _group_clock(label, place, body)
            group = f"group {sum(cell == names[0] for cell in names[: place + 1])}"
        elif name:
            values, fault = _values(label, name, place, rows)
            symbol = _cell(headers.get("SymbolName", []), place)
            unit = _unit(_cell(headers.get("Unit", []), place))
            channels.append(Channel(name, time, values, unit, group, symbol, fault))
    return channels


def _cell(cells: list[str], place: int) -> str:
    return cells[place] if place < len(cells) else ""


def _unit(text: str) -> str:
    """`mm (Length)` is mm; `(None)` is none."""
    return text.partition("(")[0].strip()


def _group_clock(
    label: str, place: int, body: list[tuple[int, list[str]]]
) -> tuple[list[tuple[int, list[str]]], NDArray[np.float64]]:
    """Rows in which the group was sampled, and their times [s]."""
    rows: list[tuple[int, list[str]]] = []
    texts: list[str] = []
    for number, cells in body:
        text = _cell(cells, place)
        if text and (not texts or text != texts[-1]):
            rows.append((number, cells))
            texts.append(text)
    for (number, _), text in zip(rows, texts, strict=True):
        if not _is_number(text):
            raise RecordingError(
                f"{label}, line {number + 1}: expected a time in milliseconds, got '{text}'; "
                "export without markers and trigger events, with one time column a group"
            )
    if texts and float(_point(texts[0])) >= _FILETIME_FROM:
        for (number, _), text in zip(rows, texts, strict=True):
            if not (text.isdecimal() and len(text) <= _FILETIME_DIGITS):
                raise RecordingError(
                    f"{label}, line {number + 1}: expected a time in ticks of 100 ns as in the "
                    f"first row, got '{text}'; export with one kind of time"
                )
        # As integers: a float of this size is good to microseconds only.
        ticks = np.array([int(text) for text in texts], dtype=np.int64)
        return rows, (ticks - ticks[0]).astype(np.float64) / _FILETIME_PER_S
    return rows, np.array([float(_point(text)) for text in texts], dtype=np.float64) / 1000.0


def _values(
    label: str, name: str, place: int, rows: list[tuple[int, list[str]]]
) -> tuple[NDArray[np.float64], str]:
    values = np.full(len(rows), np.nan)
    for k, (number, cells) in enumerate(rows):
        text = _cell(cells, place)
        if _is_number(text):
            values[k] = float(_point(text))
        elif text:
            return values, (
                f"{label}, line {number + 1}, channel '{name}': expected a number, got '{text}'; "
                "correct the cell, or leave it blank if not sampled"
            )
    return values, ""


def _point(text: str) -> str:
    return text.replace(",", ".")


def _is_number(text: str) -> bool:
    try:
        return "_" not in text and bool(np.isfinite(float(_point(text))))
    except ValueError:
        return False


def _start_time(head: list[list[str]]) -> str:
    for cells in head:
        if cells[0] in _START and len(cells) > 1 and cells[1].isdecimal():
            try:
                since = timedelta(microseconds=int(cells[1]) // 10)
                return (datetime(1601, 1, 1, tzinfo=UTC) + since).isoformat()
            except (OverflowError, ValueError):
                return ""  # beyond the year 9999
    return ""
