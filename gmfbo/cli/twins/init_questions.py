"""Questions of `gmfbo init` at a terminal: which column is which signal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from gmfbo.cli.twins.column_options import column_settings, counted_rows
from gmfbo.cli.twins.columns import print_columns
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from gmfbo.recordings.columns.column_mapping import MappedColumn
    from gmfbo.sources.first_twin.log_columns import LogColumns
    from gmfbo.sources.first_twin.signals import Signals

_NONE = "-"


def answered(signals: Signals, log: LogColumns, settled: Mapping[str, MappedColumn]) -> LogColumns:
    """Ask for the column of each signal, with the guess as what Enter takes.

    Parameters
    ----------
    signals : Signals
        Of the FMU.
    log : LogColumns
        With guesses.
    settled : mapping of str to MappedColumn
        What flags state; it is not asked again.
    """
    found = {name: entry.column for name, entry in log.mapping.columns.items()}
    stated = {column: name for name, column in found.items() if name not in log.why}
    print_columns(log.file, stated, {n: column for n, column in found.items() if n in log.why})
    typer.echo(f"Which column is it? Enter takes [the guess], {_NONE} is none; a unit may follow.")
    log = _asked(log, "time", "time", "s", settled)
    for name, signal in signals.known.items():
        if signal.usual or name in log.mapping.columns:
            unit = signal.variable.si_unit
            shown = f" [{unit}]" if unit else ""
            log = _asked(log, name, f"{name}, {signal.variable.name}{shown}", unit, settled)
    return log


def _asked(
    log: LogColumns, name: str, words: str, unit: str, settled: Mapping[str, MappedColumn]
) -> LogColumns:
    if name in settled:
        return log
    guess = _guess(log, name)
    while True:
        answer = str(typer.prompt(words, default=guess or _NONE)).strip()
        if answer == guess:
            return log  # stays a guess, and is marked as one
        if answer == _NONE:
            return log.without(name)
        try:
            return log.with_entry(name, _entry(log, name, answer, unit), "")
        except InputError as error:
            typer.echo(str(error))


def _guess(log: LogColumns, name: str) -> str:
    if name not in log.mapping.columns:
        return ""
    entry, unit = log.mapping.columns[name], log.unit(name)
    if entry.sample_time is not None:
        return f"{entry.sample_time:g}"
    return f"{entry.column} [{unit}]" if unit else entry.column


def _entry(log: LogColumns, name: str, answer: str, unit: str) -> MappedColumn:
    if name == "time" and (seconds := _number(answer)) is not None:
        return counted_rows(seconds)["time"]
    from gmfbo.recordings.columns.column_mapping import setting_fault

    (entry,) = column_settings([f"{name}={answer}"]).values()
    fault = setting_fault(name, entry, log.file, unit)
    if fault:
        raise InputError(fault)
    return entry


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
