"""Columns of a file become a recording: names, units, scale, schedules, clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.recordings.columns.clock import check_clock, check_order, unrounded
from gmfbo.recordings.columns.columns import Column, RecordedColumns, find_clock
from gmfbo.recordings.columns.instants import one_row_an_instant, resampled
from gmfbo.recordings.columns.signal_values import plain_values, signal_values
from gmfbo.units import parse_unit

if TYPE_CHECKING:
    from gmfbo.recordings.columns.signal import SignalReading, SignalSpec


_MAPPED = "; 'gmfbo columns' shows the file's columns and maps them"


@dataclass
class _Reading:
    signals: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    schedules: dict[str, NDArray[np.float64]] = field(default_factory=dict)


def interpreted(
    file: RecordedColumns, twin: SignalReading | None, resample: float | None = None
) -> dict[str, Any]:
    """Interpret a file's columns as signals and parameters.

    Parameters
    ----------
    file : RecordedColumns
        Columns, scalars and notes.
    twin : SignalReading or None
        Tells which columns are signals and which names are FMU parameters. Columns that it does
        not name are kept as signals under their own name. Without it each column with numbers
        is a signal, and each scalar a parameter.
    resample : float or None
        [s] Step of an even clock that the rows are put on; None leaves them as they are.

    Returns
    -------
    dict
        Fields of a `Recording`, in SI.

    Raises
    ------
    RecordingError
        The clock, a cell, a unit or a name does not fit; one line that names the place.
    """
    if not file.columns or file.columns[0].values.size == 0:
        raise file.refuse("expected a header and at least one row, got no row; record again")
    file, note = one_row_an_instant(file, find_clock(file.label, file.columns))
    clock = find_clock(file.label, file.columns)
    time = _time(file, clock)
    others = {column.name: column for column in file.columns if column is not clock}
    reading = _Reading()
    if twin is None:
        _read_all(others, reading, file.notes.schedules)
        reading.parameters.update(file.scalars)
    else:
        _read_signals(file, others, twin.signal_specs(), reading)
        tunable = twin.parameter_tunable()
        for name in [name for name in others if name in tunable]:
            _read_parameter(file, others.pop(name), tunable[name], time, reading)
        kept = {n: c for n, c in others.items() if n not in reading.signals and not c.fault}
        # A schedule of a parameter unknown to this twin is an ordinary column.
        _read_all(kept, reading, schedules=frozenset())
        reading.parameters.update(_known_scalars(file, tunable))
    time, told = _on_its_clock(file, reading, time, twin, resample)
    return {
        "notes": tuple(filter(None, (note, told))),
        "time": time,
        "signals": reading.signals,
        "units": reading.units,
        "name": file.label,
        "parameters": reading.parameters,
        "schedules": reading.schedules,
        "use": _use(file, time),
        "start_time": file.notes.start_time,
        "written_by": file.notes.written_by,
    }


def _checked_clock(file: RecordedColumns, reading: _Reading, time: NDArray[np.float64]) -> str:
    # A schedule keeps its value between its entries, so it has no instants of its own.
    columns = reading.signals or reading.schedules
    sampled = [np.isfinite(values) for values in columns.values()]
    return check_clock(file.label, time, sampled, file.row_name)


def _on_its_clock(
    file: RecordedColumns,
    reading: _Reading,
    time: NDArray[np.float64],
    twin: SignalReading | None,
    resample: float | None,
) -> tuple[NDArray[np.float64], str]:
    """Times of the rows, as recorded or resampled, and a note; raises for a clock that is none."""
    if resample is None:
        told = _checked_clock(file, reading, time)
        even = unrounded(time) if told else None
        if even is None:
            return time, told
        rows, tick = even
        return rows, (
            f"{file.label}: times are rounded to {1e3 * tick:g} ms; rows are taken to come evenly, "
            f"each {1e3 * (rows[1] - rows[0]):.6g} ms"
        )
    check_order(file.label, time, file.row_name)
    return _resampled(file.label, reading, time, twin, resample)


def _resampled(
    label: str,
    reading: _Reading,
    time: NDArray[np.float64],
    twin: SignalReading | None,
    step: float,
) -> tuple[NDArray[np.float64], str]:
    """Put all signals and schedules on an even clock; returns it and a note."""
    specs = {} if twin is None else twin.signal_specs()
    held = frozenset(n for n, spec in specs.items() if spec.interpolation == "hold" and spec.driven)
    even, reading.signals = resampled(time, reading.signals, held, step, label)
    schedules = frozenset(reading.schedules)
    _, reading.schedules = resampled(time, reading.schedules, schedules, step, label)
    return even, f"{label}: resampled to a row each {step:g} s, as stated"


def _time(file: RecordedColumns, clock: Column) -> NDArray[np.float64]:
    if clock.fault:
        raise RecordingError(clock.fault)
    unit = parse_unit(clock.unit or "s")
    if unit is None or unit.si != "s":
        raise file.refuse(
            f"column '{clock.name}': expected a unit of time such as [s] or [ms], "
            f"got [{clock.unit}]; correct the header"
        )
    return unit.to_si(clock.values)


def _read_all(columns: Mapping[str, Column], reading: _Reading, schedules: frozenset[str]) -> None:
    """Keep columns under their own names; a column without any number is text, and skipped."""
    for name, column in columns.items():
        if column.fault:
            if np.isfinite(column.values).any():
                raise RecordingError(column.fault)
            continue
        values, unit = plain_values(column.values, column.unit)
        if unit:
            reading.units[name] = unit
        target = reading.schedules if name in schedules else reading.signals
        target[name] = values


def _read_signals(
    file: RecordedColumns,
    columns: dict[str, Column],
    specs: Mapping[str, SignalSpec],
    reading: _Reading,
) -> None:
    taken = set()
    for name, spec in specs.items():
        # A file of ours holds signals under their own names, already scaled.
        ours = file.notes.own and name in columns
        column = columns.get(name if ours else spec.column)
        if column is None:
            _refuse_one_of_several(file, spec.column, name, columns)
            if spec.required:
                raise file.refuse(
                    f"no column '{spec.column}' for signal '{name}'"
                    + did_you_mean(spec.column, columns)
                    + _MAPPED
                )
            continue
        if column.fault:
            raise RecordingError(column.fault)
        if spec.required and not np.isfinite(column.values).any():
            raise file.refuse(
                f"column '{column.name}' for signal '{name}': expected samples, got blank cells "
                "only; record it"
            )
        try:
            values, unit = signal_values(column.values, column.unit, spec, already_scaled=ours)
        except RecordingError as error:
            raise file.refuse(f"column '{column.name}': {error}") from error
        taken.add(column.name)
        reading.signals[name] = _within_reach(file, column, values)
        if unit:
            reading.units[name] = unit
    if specs and not taken:
        wanted = sorted({spec.column for spec in specs.values()})
        raise file.refuse(
            f"expected columns for the twin's signals ({', '.join(wanted)}), got none of them"
            + did_you_mean(wanted[0], columns)
            + _MAPPED
        )
    for name in taken:
        del columns[name]


def _refuse_one_of_several(
    file: RecordedColumns, wanted: str, signal: str, columns: Mapping[str, Column]
) -> None:
    """Refuse a name that several columns have, which the reader numbered."""
    same = [name for name in columns if name.startswith(f"{wanted} (") and name[-1] in ")'"]
    numbered = [name for name in same if name[len(wanted) + 2 :].rstrip("')").isdecimal()]
    if len(numbered) > 1:
        raise file.refuse(
            f"{len(numbered)} columns are named '{wanted}': say which is signal '{signal}', "
            f'[columns] {signal} = "{numbered[0]}" in the twin file, or rename one'
        )


# Squares of larger ones overflow, of smaller ones vanish; no sensor measures either.
_LARGEST, _SMALLEST = 1e100, 1e-100


def _within_reach(
    file: RecordedColumns, column: Column, values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Refuse absurd numbers; those next to zero are zero."""
    size = np.abs(values)
    for row in np.flatnonzero(np.isfinite(values) & (size > _LARGEST))[:1]:
        raise file.refuse(
            f"column '{column.name}', {file.row_name(row)}: expected values below {_LARGEST:g}, "
            f"got {values[row]:g}; correct it, or leave it blank if not sampled"
        )
    tiny = (size < _SMALLEST) & (values != 0.0)
    return np.where(tiny, 0.0, values) if tiny.any() else values


def _read_parameter(
    file: RecordedColumns,
    column: Column,
    tunable: bool,
    time: NDArray[np.float64],
    reading: _Reading,
) -> None:
    """Read a column whose name is an FMU parameter: a schedule, or a constant."""
    if column.fault:
        raise RecordingError(column.fault)
    values, unit = plain_values(column.values, column.unit)
    known = np.isfinite(values)
    if not known[0]:
        raise file.refuse(
            f"column '{column.name}' is an FMU parameter: expected a value in the first row, "
            "got a blank cell; fill it in"
        )
    # Between its entries a parameter keeps its value.
    values = values[np.maximum.accumulate(np.where(known, np.arange(values.size), 0))]
    if unit:
        reading.units[column.name] = unit
    if tunable:
        reading.schedules[column.name] = values
        return
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    for row in changes[:1]:
        raise file.refuse(
            f"column '{column.name}' changes at {time[row]:.9g} s ({file.row_name(row)}) from "
            f"{values[row - 1]:g} to {values[row]:g}, but this FMU parameter is fixed during a "
            "run; split the recording there"
        )
    reading.parameters[column.name] = float(values[0])


def _known_scalars(file: RecordedColumns, tunable: Mapping[str, bool]) -> dict[str, float]:
    for name in file.unreadable.keys() & tunable.keys():
        raise RecordingError(file.unreadable[name])
    known = {name: value for name, value in file.scalars.items() if name in tunable}
    folded = {name.lower(): name for name in tunable}
    for name in file.scalars:
        if file.declared and name not in tunable and name.lower() in folded:
            raise file.refuse(f"no FMU parameter '{name}'; did you mean '{folded[name.lower()]}'?")
    return known


def _use(file: RecordedColumns, time: NDArray[np.float64]) -> tuple[float, float] | None:
    use = file.notes.use
    if use is None or (use[0] < use[1] and use[0] < time[-1] and use[1] > time[0]):
        return use
    raise file.refuse(
        f"use = {use[0]:g}:{use[1]:g} selects nothing of a recording from {time[0]:g} s to "
        f"{time[-1]:g} s; give first and last time in seconds"
    )
