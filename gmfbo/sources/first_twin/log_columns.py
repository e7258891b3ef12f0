"""Columns of a log for the signals of an FMU: stated by the user, or guessed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gmfbo.errors import InputError, did_you_mean
from gmfbo.recordings.columns.column_guesses import ColumnGuess, guess_columns
from gmfbo.recordings.columns.column_mapping import (
    ColumnMapping,
    MappedColumn,
    check_settings,
)
from gmfbo.recordings.columns.columns import (
    Column,
    RecordedColumns,
    find_clock,
    has_clock,
    last_part,
)
from gmfbo.recordings.columns.presets import preset_columns
from gmfbo.recordings.columns.row_spacing import mistaken_time_unit
from gmfbo.recordings.columns.unit_in_name import names_and_units, with_units_of_names
from gmfbo.recordings.reader import read_columns
from gmfbo.sources.first_twin.signals import Signal, Signals
from gmfbo.units import number, parse_unit

_STEP_S = 1e-3  # of simulations of a drive: the period of usual position controllers


@dataclass(frozen=True)
class StatedColumns:
    """What the user states about a log.

    Attributes
    ----------
    settings : mapping of str to MappedColumn
        Columns by signal, FMU variable or `time`; an empty column leaves a signal out.
    preset : str or None
        Logger whose columns are known.
    dialect : str
        How a text file is written.
    """

    settings: Mapping[str, MappedColumn]
    preset: str | None = None
    dialect: str = "auto"


@dataclass(frozen=True, eq=False)
class LogColumns:
    """Columns that were found in a log.

    Attributes
    ----------
    path : Path
        The log.
    file : RecordedColumns
        Its columns.
    mapping : ColumnMapping
        Columns by signal, and `time`.
    why : mapping of str to str
        Reason of each guess, by signal; a signal that the user stated has none.
    open : mapping of str to tuple of str
        Columns that are as likely, of signals of which none was taken.
    """

    path: Path
    file: RecordedColumns
    mapping: ColumnMapping
    why: Mapping[str, str]
    open: Mapping[str, tuple[str, ...]]

    def with_entry(self, name: str, entry: MappedColumn, why: str) -> LogColumns:
        """The same with another entry of the mapping.

        Parameters
        ----------
        name : str
            Signal, or `time`.
        entry : MappedColumn
            Its column.
        why : str
            Reason for the guess; empty where the user states it.
        """
        columns = {**self.mapping.columns, name: entry}
        reasons = (
            {**self.why, name: why} if why else {k: w for k, w in self.why.items() if k != name}
        )
        left = {k: c for k, c in self.open.items() if k != name}
        mapping = replace(self.mapping, columns=columns)
        return LogColumns(self.path, self.file, mapping, reasons, left)

    def without(self, name: str) -> LogColumns:
        """The same, with a signal left out."""
        columns = {k: e for k, e in self.mapping.columns.items() if k != name}
        left = {k: c for k, c in self.open.items() if k != name}
        mapping = replace(self.mapping, columns=columns)
        return LogColumns(self.path, self.file, mapping, self.why, left)

    def unit(self, name: str) -> str:
        """Unit in which a signal's column is read; empty where nothing states one."""
        entry = self.mapping.columns[name]
        stated = (c.unit for c in self.file.columns if c.name == entry.column and not c.assumed)
        return entry.unit or next(stated, "")


def read_log(path: Path, signals: Signals, stated: StatedColumns) -> LogColumns:
    """Find the columns of an FMU's signals in a log.

    Parameters
    ----------
    path : Path
        Recording.
    signals : Signals
        Of the FMU.
    stated : StatedColumns
        What the user says; it comes before all guesses.

    Raises
    ------
    RecordingError
        The file cannot be read.
    InputError
        A name or a column that the user states does not exist.
    """
    file = read_columns(path, stated.dialect, (), every=True)
    given = _by_signal(stated.settings, signals)
    units = {name: signal.spec.unit for name, signal in signals.known.items()}
    check_settings(given, file, {"time": "s", **units})
    left_out = {name for name, e in given.items() if not e.column and e.sample_time is None}
    entries = {name: entry for name, entry in given.items() if name not in left_out}
    why: dict[str, str] = {}
    if stated.preset is not None:
        known = preset_columns(stated.preset, file, signals.known.keys())
        for name, entry in known.items():
            if name not in entries and name not in left_out:
                entries[name], why[name] = entry, f"preset {stated.preset}"
    wanted = [s for s in signals.known.values() if s.name not in {*entries, *left_out}]
    guesses = _guesses(wanted, _free(file, entries))
    for name, guess in guesses.items():
        if len(guess.columns) == 1:
            entries[name] = MappedColumn(guess.columns[0])
            why[name] = "the column has its name" if guess.same_name else "by the column's name"
    open_ = {name: guess.columns for name, guess in guesses.items() if len(guess.columns) > 1}
    specs = {name: signal.spec for name, signal in signals.known.items() if name in entries}
    mapping = with_units_of_names(file, ColumnMapping(entries, stated.dialect), specs)
    found = LogColumns(path, file, mapping, why, open_)
    return _with_clock(found, signals.report.default_step or _STEP_S)


def step_of(signals: Signals, log: LogColumns) -> tuple[float, str]:
    """Communication step [s] of a first twin, and where it comes from.

    Parameters
    ----------
    signals : Signals
        Of the FMU, which may state one.
    log : LogColumns
        Log with a clock: the twin meets its rows by whole steps of at most 1 ms.
    """
    stated = signals.report.default_step
    if stated:
        return stated, "as the FMU states"
    spacing = _spacing(log)
    if spacing is None:
        return _STEP_S, "guess: the FMU states none"
    step = spacing / max(1, int(np.ceil(spacing / _STEP_S - 1e-9)))
    return float(
        f"{step:.6g}"
    ), f"guess: the FMU states none, and rows come each {number(spacing)} s"


def _guesses(wanted: Sequence[Signal], free: Sequence[Column]) -> dict[str, ColumnGuess]:
    """Guesses by signal; of one without a usual name only a column of the same name counts."""
    every = guess_columns({s.name: s.spec for s in wanted}, free, _aliases(wanted))
    named = {name: guess for name, guess in every.items() if guess.same_name}
    taken = {guess.columns[0] for guess in named.values() if len(guess.columns) == 1}
    usual = [signal for signal in wanted if signal.usual and signal.name not in named]
    left = [column for column in free if column.name not in taken]
    return {**named, **guess_columns({s.name: s.spec for s in usual}, left, _aliases(usual))}


def _spacing(log: LogColumns) -> float | None:
    """Usual time between two rows [s]."""
    entry = log.mapping.columns["time"]
    if entry.sample_time is not None:
        return entry.sample_time
    unit = parse_unit(log.unit("time") or "s")
    clock = next((c for c in log.file.columns if c.name == entry.column), None)
    if unit is None or clock is None or clock.values.size < 2:
        return None
    steps = np.diff(unit.to_si(clock.values * (entry.scale or 1.0)))
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if steps.size else None


def _with_clock(log: LogColumns, step: float) -> LogColumns:
    """The log with an entry of its clock, and a likely unit where none is stated."""
    entry = log.mapping.columns.get("time")
    if entry is None and not has_clock(log.file.columns):
        return log
    if entry is None:
        clock = find_clock(log.file.label, log.file.columns)
        entry = MappedColumn(clock.name)
        why = "" if clock.unit else "its name; in seconds"
        if clock.assumed:
            why = "its values increase evenly; in seconds"
        log = log.with_entry("time", entry, why)
    column = next((c for c in log.file.columns if c.name == entry.column), None)
    if column is None or log.unit("time") or entry.scale is not None:
        return log
    unit = mistaken_time_unit(column, step)
    if unit is None:
        return log
    apart = number(float(np.median(np.diff(column.values))))
    return log.with_entry("time", MappedColumn(column.name, unit), f"its rows are {apart} apart")


def _by_signal(settings: Mapping[str, MappedColumn], signals: Signals) -> dict[str, MappedColumn]:
    """Settings by the signals' names; an FMU variable may be named too."""
    found = {}
    for name, entry in settings.items():
        signal = signals.by_variable.get(name, name)
        if signal != "time" and signal not in signals.known:
            known = ["time", *signals.known, *signals.by_variable]
            raise InputError(f"--set: no signal '{name}'" + did_you_mean(name, known))
        found[signal] = entry
    return found


def _free(file: RecordedColumns, entries: Mapping[str, MappedColumn]) -> list[Column]:
    """Columns of numbers that are not taken, without the clock."""
    taken = {entry.column for entry in entries.values()}
    if "time" not in entries and has_clock(file.columns):
        taken.add(find_clock(file.label, file.columns).name)
    return [
        column
        for column in file.columns
        if column.name not in taken
        and not column.fault
        and np.isfinite(column.values).any()
        and not _is_time(column)
    ]


def _is_time(column: Column) -> bool:
    units = [column.unit] if column.unit else [unit for _, unit in names_and_units(column.name)]
    known = [parse_unit(unit) for unit in units]
    return any(unit is not None and unit.si == "s" for unit in known)


def _aliases(signals: Sequence[Signal]) -> dict[str, tuple[str, ...]]:
    """Names of the FMU's variables, in full and their last part, by signal."""
    names = {signal.name: signal.variable.name for signal in signals}
    return {signal: (name, last_part(name)) for signal, name in names.items()}
