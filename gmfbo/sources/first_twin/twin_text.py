"""Text of a first twin file, in which each guess is marked."""

from __future__ import annotations

from collections.abc import Iterator

from gmfbo.sources.first_twin.log_columns import LogColumns, step_of
from gmfbo.sources.first_twin.signals import Signal, Signals
from gmfbo.sources.fmu_file.job import STOP_TIME_LINE
from gmfbo.sources.inspection.role_guesses import Guesses
from gmfbo.sources.inspection.variable_lines import described, range_lines
from gmfbo.sources.twin_file.column_file import written_entry, written_key
from gmfbo.sources.twin_file.toml_lines import toml_table, toml_text


def twin_text(signals: Signals, log: LogColumns, fmu: str) -> str:
    """Write a twin file that reads a log.

    Parameters
    ----------
    signals : Signals
        Of the FMU.
    log : LogColumns
        Where they stand in the log; outputs that it lacks are comments.
    fmu : str
        Path of the FMU, as the twin file shall name it.

    Returns
    -------
    str
        TOML. What rests on a guess says so in a comment.
    """
    step, whence = step_of(signals, log)
    logged = log.mapping.columns
    head = (
        f"# By gmfbo init, from {signals.report.path.name} and {log.path.name}. A line with "
        '"guess" rests on names and units: correct it where it is wrong.\n'
        f"name = {toml_text(signals.report.name)}\n"
        f"fmu = {toml_text(fmu)}\n"
        f"step = {step!r}  # [s] communication step, {whence}\n"
        + (f"{STOP_TIME_LINE}  # the FMU refused to run without it\n" * signals.ends_announced)
        + (f"dialect = {toml_text(log.mapping.dialect)}\n" if _is_stated(log) else "")
    )
    known = signals.known.values()
    blocks = [
        head,
        toml_table(
            "inputs",
            "recorded signal = FMU input it drives; other inputs keep their start value",
            (_entry(s) for s in known if s.driven and s.name in logged),
        ),
        toml_table(
            "outputs",
            "recorded signal = FMU variable it is compared with",
            [
                *(_entry(s) for s in known if not s.driven and s.name in logged),
                *(f"# {_bare_entry(s)}  # not in the log" for s in known if not _is_used(s, log)),
            ],
        ),
        toml_table(
            "columns",
            "signal or time = column of the logger's files",
            _columns(log),
        ),
        *_roles(signals.guesses),
    ]
    return "\n".join(block for block in blocks if block)


def _is_stated(log: LogColumns) -> bool:
    return log.mapping.dialect != "auto"


def _is_used(signal: Signal, log: LogColumns) -> bool:
    return signal.driven or signal.name in log.mapping.columns


def _entry(signal: Signal) -> str:
    return described(signal.variable, _bare_entry(signal))


def _bare_entry(signal: Signal) -> str:
    return f"{written_key(signal.name)} = {toml_text(signal.variable.name)}"


def _columns(log: LogColumns) -> Iterator[str]:
    # The clock first, as in most files.
    for name, entry in sorted(log.mapping.columns.items(), key=lambda item: item[0] != "time"):
        why = log.why.get(name, "")
        line = f"{written_key(name)} = {written_entry(entry)}"
        yield f"{line}  # guess: {why}" if why else line


def _roles(guesses: Guesses) -> Iterator[str]:
    """Tables that the diagnosis and the tuning rest on; all their lines are guesses."""
    yield toml_table(
        "gains",
        "what tuning may move = [low, high]; guess: half to twice the start value",
        range_lines(guesses.gains),
    )
    yield toml_table(
        "uncertain",
        "known only roughly = [low, high], refitted before any physics is named; guess: half to "
        "twice the start value",
        range_lines(guesses.uncertain),
    )
    for name, means, entries in (
        ("ports", "FMU inputs where left-out physics may act", guesses.ports),
        ("states", "FMU variables that physics may depend on", guesses.states),
        ("roles", "parameters with a meaning to physics", guesses.roles),
    ):
        yield toml_table(
            name,
            means,
            (f"{g.key} = {toml_text(g.variable.name)}  # guess: {g.why}" for g in entries),
        )
