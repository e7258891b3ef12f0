"""`gmfbo init`: twin file and study file from an FMU and logs of its axis."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.completion import paths_ending
from gmfbo.cli.manual import Manual
from gmfbo.cli.twins.column_options import (
    DialectName,
    PresetName,
    SampleTime,
    Settings,
    check_dialect,
    column_settings,
    counted_rows,
)
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gmfbo.recordings.columns.column_mapping import MappedColumn
    from gmfbo.sources.first_twin.log_columns import LogColumns
    from gmfbo.sources.first_twin.signals import Signals
    from gmfbo.sources.first_twin.trial import TriedLog

TWIN, STUDY, OVERLAY = "twin.toml", "study.toml", "overlay.html"

_MOST_NAMES = 12  # of columns or outputs, in one message

MANUAL = Manual(
    files={
        "DIR/twin.toml": "the twin file, with [columns] of the logger; lines with 'guess' are for "
        "you to check",
        "DIR/study.toml": "a study of its gains, where the FMU holds a loop with gains",
        "DIR/overlay.html": "recorded and simulated signals; open it in a browser",
    },
    examples={
        "Of an FMU and two logs:": "gmfbo init vendor.fmu run1.csv run2.csv --out axis",
        "Say what it cannot guess:": (
            "gmfbo init vendor.fmu log.mat --set 'position=log.y [deg]' --out axis"
        ),
        "Of a known logger:": "gmfbo init vendor.fmu odrive.csv --preset odrive --out axis",
    },
    exits={3: "the FMU failed on the first log; nothing is written"},
    see_also=("gmfbo columns", "gmfbo check", "gmfbo diagnose", "notebooks/docs/vendor_fmu.md"),
)


def init(
    fmu: Annotated[
        Path,
        typer.Argument(metavar="FMU", help="FMU file (.fmu).", autocompletion=paths_ending(".fmu")),
    ],
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="Recordings of the axis, of one logger."),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the files.")],
    set_: Settings = None,
    preset: PresetName = None,
    dialect: DialectName = None,
    sample_time: SampleTime = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Ask nothing at a terminal: take the guesses.")
    ] = False,
) -> None:
    """Write twin and study files for an FMU and its logs.

    Signals, their columns and units, gains, ports and states are guessed from names and units,
    and each guess is marked. At a terminal it asks for the columns; elsewhere --set says what it
    cannot guess, and NAME=- leaves a signal out. Then it simulates the logs: by that it settles
    units that no file states, prints the errors and draws them.
    """
    from gmfbo.sources.first_twin.log_columns import StatedColumns, read_log
    from gmfbo.sources.first_twin.signals import signals_of
    from gmfbo.sources.first_twin.trial import tried_in_likely_units
    from gmfbo.sources.inspection.inspection import inspect_fmu

    check_dialect(dialect)
    _check_folder(out)
    signals = signals_of(inspect_fmu(fmu))
    settings = {**_settings(set_ or []), **counted_rows(sample_time)}
    stated = StatedColumns(settings, preset, dialect or "auto")
    log = read_log(logs[0], signals, stated)
    if sys.stdin.isatty() and not yes:
        from gmfbo.cli.twins.init_questions import answered

        log = answered(signals, log, settings)
    _check_found(signals, log)
    signals, log, seen = tried_in_likely_units(signals, log, logs)
    _print_columns(signals, log)
    _print_errors(seen)
    written = _write_all(out, signals, log, seen)
    typer.echo(f"{'written':<17}{', '.join(str(out / name) for name in written)}")
    if STUDY not in written:
        typer.echo(f"{'no study':<17}{_why_no_study(signals)}")
    typer.echo(f"{'look at':<17}{out / OVERLAY}, and the lines with 'guess' in {out / TWIN}")
    typer.echo(f"{'then':<17}gmfbo check {out / TWIN} {' '.join(map(str, logs))}")


def _settings(texts: list[str]) -> dict[str, MappedColumn]:
    """Settings of the flags; an empty column leaves a signal out."""
    from dataclasses import replace

    given = column_settings(texts)
    return {n: replace(e, column="") if e.column == "-" else e for n, e in given.items()}


def _check_folder(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise InputError(f"--out: expected a folder, but '{out}' is a file; give another name")
    there = [name for name in (TWIN, STUDY) if (out / name).exists()]
    if there:
        raise InputError(
            f"'{out / there[0]}' is there already; give another --out, or move it away"
        )


def _check_found(signals: Signals, log: LogColumns) -> None:
    """Raise for what only the user knows: a clock, an input's column, one of two columns."""
    label, found = log.file.label, log.mapping.columns
    names = ", ".join(column.name for column in log.file.columns[:_MOST_NAMES])
    if "time" not in found:
        raise InputError(
            f"{label}: no clock among the columns {names}; say which with "
            "--set 'time=COLUMN [ms]', or, if there is none, how far apart its rows are with "
            "--sample-time 0.001"
        )
    for name, columns in log.open.items():
        raise InputError(
            f"{label}: {' and '.join(columns)} may both be {name} "
            f"({signals.known[name].variable.name}); say which with --set {name}=COLUMN, or leave "
            f"it out with --set {name}=-"
        )
    lacking = [signal for signal in signals.driven if signal.name not in found]
    if lacking and len(lacking) == len(signals.driven):
        name = lacking[0].name
        raise InputError(
            f"{label}: none of the columns {names} looks like {name}, which drives the FMU's input "
            f"{lacking[0].variable.name}; say which with --set {name}=COLUMN"
        )
    if not any(signal.name in found for signal in signals.known.values() if not signal.driven):
        outputs = [s for s in signals.known.values() if not s.driven]
        if not outputs:
            raise InputError(
                f"{signals.report.path.name}: it has no output that {label} could be held against; "
                "give an FMU with outputs"
            )
        wanted = [s.name for s in outputs if s.usual] or [s.name for s in outputs]
        told = ", ".join(wanted[:_MOST_NAMES]) + (", ..." if len(wanted) > _MOST_NAMES else "")
        raise InputError(
            f"{label}: none of the columns {names} looks like an output of the FMU "
            f"({told}); say which with --set NAME=COLUMN"
        )


def _print_columns(signals: Signals, log: LogColumns) -> None:
    from gmfbo.sources.first_twin.log_columns import step_of

    step, whence = step_of(signals, log)
    report = signals.report
    typer.echo(f"{report.path.name}: {report.name}, FMI {report.fmi_version}")
    typer.echo(f"{'step':<17}{step:g} s, {whence}")
    for name, entry in log.mapping.columns.items():
        unit = log.unit(name)
        column = f"{entry.column} [{unit}]" if unit else entry.column
        if entry.sample_time is not None:
            column = f"a row each {entry.sample_time:g} s"
        why = f"guess: {log.why[name]}" if name in log.why else ""
        typer.echo(f"{name:<17}{column:<24} {why}".rstrip())
    lacking = [name for name in signals.known if name not in log.mapping.columns]
    if lacking:
        typer.echo(f"{'not in the log':<17}{', '.join(lacking)}")


def _print_errors(seen: Sequence[TriedLog]) -> None:
    from gmfbo.plain_words import percent

    names = list(dict.fromkeys(name for one in seen for name in one.errors))
    typer.echo(f"{'error (NRMSE)':<17}" + "  ".join(f"{name:>14}" for name in names))
    for one in seen:
        cells = (percent(one.errors.get(name, float("nan"))) for name in names)
        typer.echo(f"{one.recording.name:<17}" + "  ".join(f"{cell:>14}" for cell in cells))
    for doubt in dict.fromkeys(doubt for one in seen for doubt in one.doubts):
        typer.echo(f"! {doubt}")


def _write_all(
    out: Path, signals: Signals, log: LogColumns, seen: Sequence[TriedLog]
) -> tuple[str, ...]:
    """Write the files; returns their names."""
    from gmfbo.files.durable import cause, write_whole
    from gmfbo.reports.overlay.page import Overlay, overlay_page
    from gmfbo.sources.first_twin.twin_text import twin_text

    overlays = [Overlay(one.recording, one.run, one.errors, one.doubts) for one in seen]
    story = "What was recorded, and what the twin makes of the same inputs as it came."
    texts = {
        TWIN: twin_text(signals, log, _fmu_path(signals.report.path, out)),
        STUDY: _study_text(signals, log, seen[0]),
        OVERLAY: overlay_page(signals.report.name, story, overlays),
    }
    written = tuple(name for name, text in texts.items() if text)
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name in written:
            write_whole(out / name, texts[name].encode("utf-8"))
    except OSError as error:
        raise InputError(f"--out: '{out}' cannot be written: {cause(error)}") from None
    return written


def _study_text(signals: Signals, log: LogColumns, seen: TriedLog) -> str:
    """Text of the study file; empty where there is nothing to tune."""
    import numpy as np

    from gmfbo.sources.first_twin.log_columns import step_of
    from gmfbo.sources.first_twin.trial import settled_after
    from gmfbo.tuning.study_file.first_study import FirstStudy, first_study_text, round_step

    if _why_no_study(signals):
        return ""
    asked = seen.recording.signals.get("reference", np.zeros(1))
    away = asked[np.isfinite(asked)]
    height = round_step(float(np.abs(away - away[:1]).max(initial=0.0))) or 1.0
    answer = signals.controlled
    assert answer is not None, "there is a study"
    return first_study_text(
        FirstStudy(
            name=signals.report.name,
            twin=TWIN,
            signal=answer.name,
            step=height,
            unit=signals.known["reference"].variable.si_unit,
            sample_time=step_of(signals, log)[0],
            horizon=settled_after(signals, log, height),
            source=f"as far as {log.path.name} goes, and as long as the twin takes",
        )
    )


def _why_no_study(signals: Signals) -> str:
    """Why there is nothing to tune, and what to do; empty where there is."""
    from gmfbo.sources.inspection.variable_lines import range_lines

    if signals.controlled is None:
        return (
            "the FMU holds no loop with a reference; a controller can join it by [fmus] "
            "(notebooks/docs/fmus.md)"
        )
    if not list(range_lines(signals.guesses.gains)):
        return "no parameter looks like a gain; write [gains] into the twin file, then a study file"
    return ""


def _fmu_path(fmu: Path, out: Path) -> str:
    """Path of the FMU from the twin file's folder; absolute where there is none, on Windows."""
    import os

    try:
        return Path(os.path.relpath(fmu.resolve(), out.resolve())).as_posix()
    except ValueError:
        return fmu.resolve().as_posix()
