"""Rows of one instant become one, and rows are put on an even clock where that is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column, RecordedColumns

_MOST_ROWS = 10_000_000  # of a resampled recording; more are a mistake in its step


def one_row_an_instant(file: RecordedColumns, clock: Column) -> tuple[RecordedColumns, str]:
    """Join neighbouring rows of one instant, as loggers of messages and of events write them.

    A cell that is blank in one row is filled from the other. Of two values the last counts: it
    is the one after an event.

    Parameters
    ----------
    file : RecordedColumns
        As read.
    clock : Column
        One of its columns.

    Returns
    -------
    tuple of RecordedColumns and str
        The file, unchanged where no instant stands twice; and a note, empty then.

    Raises
    ------
    RecordingError
        Three rows of one instant hold different values, or most instants stand twice: the clock
        has too few digits.
    """
    time = clock.values
    same = time[1:] == time[:-1]
    if clock.fault or not same.any():
        return file, ""
    first = np.flatnonzero(np.append(True, ~same))  # row of each instant
    last = np.append(first[1:], time.size) - 1
    group = np.cumsum(np.append(True, ~same)) - 1
    joined, clashes = [], np.zeros(first.size, dtype=int)
    for column in file.columns:
        values, differing = _joined(column.values, group, first)
        joined.append(replace(column, values=values))
        clashes = np.maximum(clashes, differing)
    few_digits = np.flatnonzero(clashes > 1)[:1]
    if not few_digits.size and 2 * int((clashes > 0).sum()) > first.size:
        few_digits = np.flatnonzero(clashes > 0)[:1]
    for instant in few_digits:
        raise RecordingError(
            f"{file.label}, {file.row_name(int(first[instant]) + 1)}: time "
            f"{time[first[instant]]:.9g} s stands twice with different values, as in many rows; "
            "log time with enough digits"
        )
    shared = int((last > first).sum())
    some = "1 instant stands" if shared == 1 else f"{shared} instants stand"
    note = (
        f"{file.label}: {some} in several rows, which are taken as one; of two values the last "
        "counts"
    )
    place = file.row_name
    whole = replace(file, columns=tuple(joined), row_name=lambda row: place(int(first[row])))
    return whole, note


def _joined(
    values: NDArray[np.float64], group: NDArray[np.int_], first: NDArray[np.int_]
) -> tuple[NDArray[np.float64], NDArray[np.int_]]:
    """Last value of each group that is not blank, and how often it changes within the group."""
    joined = np.full(first.size, np.nan)
    rows = np.flatnonzero(~np.isnan(values))
    joined[group[rows]] = values[rows]  # of several rows of a group NumPy keeps the last
    clashes = np.zeros(first.size, dtype=int)
    known = values[rows]
    again = rows[1:][(np.diff(group[rows]) == 0) & (known[1:] != known[:-1])]
    np.add.at(clashes, group[again], 1)
    return joined, clashes


def resampled(
    time: NDArray[np.float64],
    columns: Mapping[str, NDArray[np.float64]],
    held: frozenset[str],
    step: float,
    label: str,
) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Put columns on an even clock, by interpolation between their own instants.

    Nothing is filtered: what is faster than half the new rate must not be in the signals.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Increasing.
    columns : mapping of str to ndarray, shape (n,)
        NaN where not sampled.
    held : frozenset of str
        Columns that keep their value until the next one, as commands do.
    step : float
        [s] Between the new rows.
    label : str
        File name, for the message.

    Returns
    -------
    time : ndarray, shape (m,)
        [s] From the first row on.
    columns : dict of str to ndarray, shape (m,)
        NaN before a column's first sample and after its last.

    Raises
    ------
    RecordingError
        That makes too many rows.
    """
    count = int((time[-1] - time[0]) / step * (1.0 + 1e-12) + 1e-6) + 1
    if count > _MOST_ROWS:
        raise RecordingError(
            f"{label}: [recording] resample = {step:g} makes {count} rows of "
            f"{time[-1] - time[0]:g} s, expected at most {_MOST_ROWS}; is its time in another "
            "unit? else give a longer step"
        )
    even = time[0] + step * np.arange(count)
    put: dict[str, NDArray[np.float64]] = {}
    slack = 1e-6 * step  # an instant that is written in decimals
    for name, values in columns.items():
        known = np.isfinite(values)
        own, kept = time[known], values[known]
        if own.size == 0:
            put[name] = np.full(count, np.nan)
            continue
        if name in held:
            rows = np.searchsorted(own, even + slack, side="right") - 1
            put[name] = np.where(rows >= 0, kept[np.clip(rows, 0, None)], np.nan)
            continue
        inside = (even >= own[0] - slack) & (even <= own[-1] + slack)
        put[name] = np.where(inside, np.interp(even, own, kept), np.nan)
    return even, put
