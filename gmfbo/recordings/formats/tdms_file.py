"""Recordings as TDMS, the files of LabVIEW, DIAdem and TwinCAT Scope, through npTDMS."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import Column, FileNotes, find_clock
from gmfbo.recordings.formats.optional_package import load_package
from gmfbo.units import parse_unit


def read_tdms(path: Path) -> RecordedChannels:
    """Read the channels of a TDMS file.

    A waveform channel has a clock of its own (`wf_increment`, `wf_start_offset`,
    `wf_start_time`). Other channels share the clock of their group: a channel `time`, one in a
    unit of time, or one of timestamps. The unit is the property `unit_string`. Numbers among the
    properties of the file are scalars.

    Raises
    ------
    RecordingError
        The file is no TDMS file, or npTDMS is not installed.
    OSError
        The file cannot be read.
    """
    nptdms = load_package("nptdms", "tdms", path.name)
    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        file = nptdms.TdmsFile.read(path)
    except OSError:
        raise
    except Exception as error:  # any exception may come out of npTDMS
        raise RecordingError(
            f"{path.name}: expected a TDMS file, got something else or a damaged one "
            f"({' '.join(str(error).split())}); copy it again, or give it its right ending"
        ) from error
    starts = [_start(channel) for group in file.groups() for channel in group.channels()]
    first = min((start for start in starts if start is not None), default=None)
    channels: list[Channel] = []
    for group in file.groups():
        channels += _group(path.name, group.name, group.channels(), first)
    scalars = {
        name: float(value)
        for name, value in file.properties.items()
        if isinstance(value, int | float | np.number)
    }
    began = "" if first is None else str(first.astype("datetime64[us]")) + "Z"
    return RecordedChannels(path.name, tuple(channels), scalars, FileNotes(start_time=began))


def _group(
    label: str, group: str, channels: Iterable[Any], first: np.datetime64 | None
) -> list[Channel]:
    waves: list[tuple[Any, NDArray[Any]]] = []
    plain: list[tuple[Any, NDArray[Any]]] = []
    for channel in channels:
        values = np.asarray(channel[:])
        if values.dtype.kind not in "biufM" or values.ndim != 1:
            continue  # text
        (waves if float(channel.properties.get("wf_increment", 0.0)) > 0.0 else plain).append(
            (channel, values)
        )
    read = [
        Channel(c.name, _waveform(c, v.size, first), v.astype(np.float64), _unit(c), group)
        for c, v in waves
        if v.dtype.kind != "M"
    ]
    return read + _on_one_clock(label, group, plain)


def _on_one_clock(label: str, group: str, plain: list[tuple[Any, NDArray[Any]]]) -> list[Channel]:
    """Channels of a group whose clock is one of them."""
    columns = []
    for channel, values in plain:
        if values.dtype.kind == "M":
            seconds = (values - values[:1]) / np.timedelta64(1, "s")
            columns.append(Column(channel.name, seconds.astype(np.float64), "s"))
        else:
            columns.append(Column(channel.name, values.astype(np.float64), _unit(channel)))
    if not columns:
        return []
    try:
        clock = find_clock(f"{label}, group '{group}'", tuple(columns))
    except RecordingError as error:
        # A group without a clock matters only if the twin needs one of its channels.
        return [
            Channel(
                c.name,
                np.arange(c.values.size, dtype=np.float64),
                c.values,
                c.unit,
                group,
                "",
                str(error),
                counted=True,
            )
            for c in columns
        ]
    time = _clock_seconds(clock)
    return [
        Channel(c.name, time, c.values, c.unit, group)
        if c.values.size == time.size
        else _uneven(label, c, group, time)
        for c in columns
        if c is not clock
    ]


def _clock_seconds(clock: Column) -> NDArray[np.float64]:
    unit = parse_unit(clock.unit or "s")
    return clock.values if unit is None or unit.si != "s" else unit.to_si(clock.values)


def _uneven(label: str, column: Column, group: str, time: NDArray[np.float64]) -> Channel:
    fault = (
        f"{label}: channel '{group}/{column.name}' has {column.values.size} values, expected "
        f"{time.size} as the clock of its group; write it as a waveform, or in a group of its own"
    )
    return Channel(column.name, time, np.full(time.size, np.nan), column.unit, group, "", fault)


def _start(channel: Any) -> np.datetime64 | None:
    start = channel.properties.get("wf_start_time")
    waveform = float(channel.properties.get("wf_increment", 0.0)) > 0.0
    if start is None or not waveform or np.isnat(np.datetime64(start)):
        return None
    return np.datetime64(start, "ns")


def _waveform(channel: Any, rows: int, first: np.datetime64 | None) -> NDArray[np.float64]:
    """Times [s] of a waveform, from the earliest start of all waveforms."""
    step = float(channel.properties["wf_increment"])
    offset = float(channel.properties.get("wf_start_offset", 0.0))
    start = _start(channel)
    if start is not None and first is not None:
        offset += float((start - first) / np.timedelta64(1, "s"))
    return offset + np.arange(rows, dtype=np.float64) * step


def _unit(channel: Any) -> str:
    return str(channel.properties.get("unit_string", channel.properties.get("unit", ""))).strip()
