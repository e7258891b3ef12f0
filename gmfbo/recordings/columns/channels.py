"""Channels with a clock each, and their conversion to the columns of one recording.

Measuring systems sample each channel at its own rate. The rows of a recording are the union of all
sampling instants, and a channel is blank where it was not sampled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.clock import is_steady
from gmfbo.recordings.columns.columns import Column, FileNotes, RecordedColumns, last_part
from gmfbo.recordings.columns.equal_length import columns_of_equal_length

# Instants closer than this share of the shortest step are the same: clocks of several channels
# differ by round-off, less than a nanosecond in a microsecond.
SAME_INSTANT = 1e-4


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel with its own clock.

    Attributes
    ----------
    name : str
        Name in the file.
    time : ndarray, shape (n,)
        [s]
    values : ndarray, shape (n,)
        NaN where the file has no number.
    unit : str
        As written; empty where none is.
    group : str
        Group in the file; distinguishes channels of one name as `group/name`.
    alias : str
        Another name that the file gives, such as the full path of a variable; empty without one.
    fault : str
        Why the channel cannot be used; empty where it can.
    counted : bool
        Whether `time` only counts the samples, since the file states no clock; `fault` says so.
    """

    name: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    unit: str = ""
    group: str = ""
    alias: str = ""
    fault: str = ""
    counted: bool = False


@dataclass(frozen=True, eq=False)
class RecordedChannels:
    """Content of a file of channels, before a twin gives it a meaning.

    Attributes
    ----------
    label : str
        File name, for messages.
    channels : tuple of Channel
        In the file's order.
    scalars : mapping of str to float
        Single values: candidates for FMU parameters in force.
    notes : FileNotes
        Metadata of the file.
    """

    label: str
    channels: tuple[Channel, ...]
    scalars: Mapping[str, float] = field(default_factory=dict)
    notes: FileNotes = field(default_factory=FileNotes)

    def columns(
        self, wanted: Iterable[str] | None = None, *, every: bool = False
    ) -> RecordedColumns:
        """Put channels on one clock.

        Parameters
        ----------
        wanted : iterable of str or None
            Names that a twin needs. The rows are then the instants of these channels, and other
            channels are kept only if they share a clock with one of them. Without names, or where
            none is found, all channels with a steady clock are kept.
        every : bool
            Keep all channels.

        Returns
        -------
        RecordedColumns
            With a column `time` [s] in front, unless the file states no clock at all.

        Raises
        ------
        RecordingError
            There is no channel with samples.
        """
        wanted = set(wanted or ())
        named = _named(self.channels, wanted)
        if not any(channel.time.size for channel in named):
            raise RecordingError(
                f"{self.label}: expected channels with samples, got "
                f"{len(self.channels) or 'none'}{' without any' if self.channels else ''}; "
                "record again"
            )
        chosen = [c for c in named if c.time.size] if every else _chosen(named, wanted)
        if all(channel.counted for channel in chosen):
            return self._without_clock(chosen)
        grid = _grid([channel.time for channel in chosen])
        columns = [_on_grid(self.label, channel, grid) for channel in chosen]
        return RecordedColumns(
            label=self.label,
            columns=(Column("time", grid, "s"), *columns),
            scalars=self.scalars,
            notes=self.notes,
        )

    def _without_clock(self, channels: Sequence[Channel]) -> RecordedColumns:
        """Columns without a time; the twin file may state the time between their rows."""
        arrays = {channel.name: channel.values for channel in channels}
        units = {channel.name: channel.unit for channel in channels}
        read = columns_of_equal_length(self.label, arrays, units)
        return replace(read, scalars={**read.scalars, **self.scalars}, notes=self.notes)


def _named(channels: Sequence[Channel], wanted: set[str]) -> list[Channel]:
    """Give each channel a unique name: a wanted one, its own, or group and name."""
    count = Counter(channel.name for channel in channels)
    seen: Counter[str] = Counter()
    named = []
    for channel in channels:
        qualified = f"{channel.group}/{channel.name}" if channel.group else channel.name
        name = channel.name if count[channel.name] == 1 else qualified
        seen[name] += 1
        if seen[name] > 1:
            name = f"{name} ({seen[name]})"
        named.append(replace(channel, name=name, alias=channel.alias or qualified))
    known = {channel.name for channel in named}
    for want in sorted(wanted):
        if want in known:
            continue
        places = [
            k
            for k, (old, new) in enumerate(zip(channels, named, strict=True))
            if want in (new.alias, f"{old.group}/{old.name}")
        ]
        if not places:
            places = [
                k
                for k, channel in enumerate(named)
                if last_part(channel.name) == want and channel.name not in wanted
            ]
        if len(places) == 1:  # an alias of several channels is ambiguous
            named[places[0]] = replace(named[places[0]], name=want)
    return named


def _chosen(channels: Sequence[Channel], wanted: set[str]) -> list[Channel]:
    filled = [channel for channel in channels if channel.time.size]
    needed = [channel for channel in filled if channel.name in wanted]
    if needed:
        clocks = {_key(channel.time) for channel in needed}
        return [c for c in filled if c.name in wanted or _key(c.time) in clocks]
    steady = [channel for channel in filled if is_steady(channel.time) and not channel.fault]
    return steady or filled


def _key(time: NDArray[np.float64]) -> bytes:
    return time.tobytes()


def _grid(clocks: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """All instants in order, those that differ only by round-off merged."""
    distinct = list({_key(clock): clock for clock in clocks}.values())
    if len(distinct) == 1:
        return distinct[0]
    steps = [float(np.median(np.diff(clock))) for clock in distinct if clock.size > 1]
    instants = np.sort(np.concatenate(distinct))
    round_off = 4.0 * float(np.spacing(np.max(np.abs(instants))))
    near = max(SAME_INSTANT * min((step for step in steps if step > 0.0), default=0.0), round_off)
    new = np.ones(instants.size, dtype=bool)
    new[1:] = np.diff(instants) > near
    grid: NDArray[np.float64] = instants[new]
    return grid


def _on_grid(label: str, channel: Channel, grid: NDArray[np.float64]) -> Column:
    values = np.full(grid.size, np.nan)
    if channel.fault:
        return Column(channel.name, values, channel.unit, channel.fault)
    if channel.time is grid:
        return Column(channel.name, channel.values, channel.unit)
    back = np.flatnonzero(np.diff(channel.time) <= 0.0)
    if back.size:
        row = int(back[0]) + 1
        fault = (
            f"{label}: the clock of channel '{channel.name}' goes from {channel.time[row - 1]:.9g} "
            f"s to {channel.time[row]:.9g} s at sample {row + 1}; expected times that increase"
        )
        return Column(channel.name, values, channel.unit, fault)
    # The grid has the first instant of a cluster, so a sample belongs to the one at or before it.
    rows = np.searchsorted(grid, channel.time, side="right") - 1
    values[rows] = channel.values
    return Column(channel.name, values, channel.unit)
