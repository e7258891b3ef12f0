"""`gmfbo columns`: map a logger's columns to signals, and save the mapping."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import TwinFile
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
from gmfbo.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedColumn
    from gmfbo.recordings.columns.columns import Column, RecordedColumns
    from gmfbo.sources.twin.twin import FmuTwin

_TYPO = 0.75  # likeness from which a name is a slip: one letter in four


MANUAL = Manual(
    files={
        "FILE": "of --save: [columns] of the twin file, if FILE is TWIN; else the mapping in a "
        "file of its own, for the line 'columns = ...' of several twin files"
    },
    examples={
        "What is in a file:": "gmfbo columns axis.toml log.csv",
        "Of a VESC:": "gmfbo columns axis.toml vesc.csv --preset vesc --save axis.toml",
        "Say what it is, and keep it:": (
            "gmfbo columns axis.toml log.csv --set 'position=Pos [deg]' --save axis.toml"
        ),
    },
    see_also=("gmfbo check", "notebooks/docs/recordings.md", "notebooks/docs/studies.md"),
)


def columns(
    twin: TwinFile,
    recording: Annotated[Path, typer.Argument(metavar="REC", help="Recording of the logger.")],
    set_: Settings = None,
    dialect: DialectName = None,
    sample_time: SampleTime = None,
    preset: PresetName = None,
    save: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the mapping to this .toml file; TWIN itself too."),
    ] = None,
) -> None:
    """Show which column of a recording is which signal of a twin.

    With the unit of each column and its range [that unit]. --preset fills in a known logger's
    columns, --set corrects it, --save keeps it for the next recordings: in the twin file itself,
    whose other lines stay, or in a file that a line of the twin file then names.
    """
    from gmfbo.recordings.columns.column_mapping import ColumnMapping
    from gmfbo.recordings.reader import read_columns
    from gmfbo.sources.twin.twin import FmuTwin

    _check_options(dialect, save)
    if save is not None:
        _check_target(save, twin)
    with FmuTwin(twin) as source:
        given = source.column_mapping()
        settings = {**column_settings(set_ or []), **counted_rows(sample_time)}
        mapping = ColumnMapping({**given.columns, **settings}, dialect or given.dialect)
        file = read_columns(recording, mapping.dialect, _words(source, mapping), every=True)
        _check_settings(settings, source, file)
        mapping = _completed(mapping, preset, file, source)
        file = _as_mapped(file, mapping)
        found = _found(source, mapping, file)
        guesses = _guesses(source, found, file)
        _print_all(source, mapping, file, found, guesses)
        if save is not None:
            _print_notes(source, recording, mapping)
            _save(save, twin, recording, mapping, found, guesses)


def _words(source: FmuTwin, mapping: ColumnMapping) -> set[str]:
    """Names of columns that the twin asks for."""
    specs = source.signal_specs().values()
    return {*mapping.names(), *source.parameter_tunable(), *(spec.column for spec in specs)}


def _print_all(
    source: FmuTwin,
    mapping: ColumnMapping,
    file: RecordedColumns,
    found: Mapping[str, str],
    guesses: Mapping[str, str],
) -> None:
    clock = "" if mapping.sample_time else found.get("time") or _clock_name(file)
    print_columns(file, {clock: "time", **_by_column(found)}, guesses)
    if mapping.sample_time:
        typer.echo(f"time: a row each {mapping.sample_time:g} s, as stated")
    _print_missing(source, found, file, timed=bool(clock or mapping.sample_time))


def _completed(
    mapping: ColumnMapping, preset: str | None, file: RecordedColumns, source: FmuTwin
) -> ColumnMapping:
    """Mapping with what a preset and then the units in names of columns add to it."""
    from gmfbo.recordings.columns.unit_in_name import with_units_of_names

    if preset is not None:
        mapping = _with_preset(preset, mapping, file, source)
    return with_units_of_names(file, mapping, source.signal_specs())


def _with_preset(
    name: str, mapping: ColumnMapping, file: RecordedColumns, source: FmuTwin
) -> ColumnMapping:
    """Mapping with a preset's columns under those that are given, and what it leaves out."""
    from dataclasses import replace

    from gmfbo.recordings.columns.presets import find_preset, preset_columns

    preset = find_preset(name)
    columns = preset_columns(name, file, source.signal_specs().keys())
    typer.echo(f"preset {name}, by {preset.page}")
    if preset.left_out:
        typer.echo(f"preset {name}: {preset.left_out}")
    return replace(mapping, columns={**columns, **mapping.columns})


def _print_notes(source: FmuTwin, recording: Path, mapping: ColumnMapping) -> None:
    """Read the recording, which raises for an unreadable mapping, and print what was noted."""
    from gmfbo.recordings.recording import read_recording

    for note in read_recording(recording, source, mapping=mapping).notes:
        typer.echo(note)


def _check_options(dialect: str | None, save: Path | None) -> None:
    check_dialect(dialect)
    if save is not None and save.suffix.lower() != ".toml":
        raise InputError(f"--save: expected a file ending in .toml, got '{save}'")


def _check_settings(
    settings: Mapping[str, MappedColumn], source: FmuTwin, file: RecordedColumns
) -> None:
    from gmfbo.recordings.columns.column_mapping import check_settings

    _check_names(settings, source)
    units = {name: spec.unit for name, spec in source.signal_specs().items()}
    check_settings(settings, file, {"time": "s", **units})


def _check_names(settings: Mapping[str, MappedColumn], source: FmuTwin) -> None:
    """Refuse a name that is nearly one of the twin's; other names are the user's own."""
    from difflib import get_close_matches

    known = ["time", *source.signal_specs(), *source.parameter_tunable()]
    for name in settings:
        if name not in known and get_close_matches(name.lower(), map(str.lower, known), 1, _TYPO):
            raise InputError(f"--set: the twin has no '{name}'" + did_you_mean(name, known))


def _as_mapped(file: RecordedColumns, mapping: ColumnMapping) -> RecordedColumns:
    """Columns with the units in which they are read."""
    from dataclasses import replace

    # With a scale, the unit is that of the value and not of the column.
    entries = [entry for entry in mapping.columns.values() if entry.scale is None]
    units = {entry.column: entry.unit for entry in entries if entry.unit}
    columns = tuple(replace(c, unit=units.get(c.name, c.unit)) for c in file.columns)
    return replace(file, columns=columns)


def _found(source: FmuTwin, mapping: ColumnMapping, file: RecordedColumns) -> dict[str, str]:
    """Columns by the twin's names, as the readers find them."""
    names = {column.name for column in file.columns}
    found = {n: e.column for n, e in mapping.columns.items() if e.column in names}
    for name, spec in source.signal_specs().items():
        if name not in found and spec.column in names:
            found[name] = spec.column
    for name in source.parameter_tunable():
        if name in names:
            found.setdefault(name, name)
    return found


def _guesses(source: FmuTwin, found: Mapping[str, str], file: RecordedColumns) -> dict[str, str]:
    """Columns that are likely signals, where one is likelier than all others."""
    from gmfbo.recordings.columns.column_guesses import guess_columns

    taken = {*found.values(), _clock_name(file)}
    free = [c for c in file.columns if c.name not in taken and not c.fault]
    wanted = {name: spec for name, spec in source.signal_specs().items() if name not in found}
    guesses = guess_columns(wanted, free)
    return {name: g.columns[0] for name, g in guesses.items() if len(g.columns) == 1}


def _clock_name(file: RecordedColumns) -> str:
    from gmfbo.errors import RecordingError
    from gmfbo.recordings.columns.columns import find_clock

    try:
        return find_clock(file.label, file.columns).name
    except RecordingError:
        return ""  # to be named with --set time=COLUMN


def _by_column(found: Mapping[str, str]) -> dict[str, str]:
    return {column: name for name, column in found.items()}


def print_columns(
    file: RecordedColumns, names: Mapping[str, str], guesses: Mapping[str, str]
) -> None:
    """Print the columns of a file with unit and range [that unit], and what they are.

    Parameters
    ----------
    file : RecordedColumns
        The file.
    names : mapping of str to str
        Signals by column.
    guesses : mapping of str to str
        Columns by signal that are only guessed.
    """
    maybe = _by_column(guesses)
    rows = len(file.columns[0].values) if file.columns else 0
    typer.echo(f"{file.label}: {len(file.columns)} columns, {rows} rows")
    width = min(max([len(c.name) for c in file.columns] + [6]), 48)
    typer.echo(f"{'column':<{width}}  {'unit':<8}  {'samples':>8}  {'from':>11}  {'to':>11}  is")
    for column in file.columns:
        meaning = names.get(column.name, "")
        if not meaning and column.name in maybe:
            meaning = f"{maybe[column.name]}? (a guess)"
        typer.echo(f"{_row(column, width)}  {meaning}".rstrip())


def _row(column: Column, width: int) -> str:
    import numpy as np

    known = column.values[np.isfinite(column.values)]
    low, high = (f"{known.min():.5g}", f"{known.max():.5g}") if known.size else ("", "")
    if column.fault and not known.size:
        low = "no number"
    return f"{column.name:<{width}}  {column.unit:<8}  {known.size:>8}  {low:>11}  {high:>11}"


def _print_missing(
    source: FmuTwin, found: Mapping[str, str], file: RecordedColumns, *, timed: bool
) -> None:
    if "time" not in found and not timed:
        typer.echo(
            "not found: the clock; say where with --set 'time=COLUMN [ms]', or, if there is none, "
            "how far apart its rows are with --sample-time 0.001"
        )
    missing = [name for name in source.signal_specs() if name not in found]
    if missing:
        typer.echo(f"not found: {', '.join(missing)}; say where with --set {missing[0]}=COLUMN")


def _save(
    save: Path,
    twin: Path,
    recording: Path,
    mapping: ColumnMapping,
    found: Mapping[str, str],
    guesses: Mapping[str, str],
) -> None:
    from gmfbo.recordings.columns.column_mapping import MappedColumn
    from gmfbo.sources.twin_file.column_file import column_file_text

    entries = {name: MappedColumn(column) for name, column in found.items() if name != column}
    entries.update(mapping.columns)
    if _is_twin(save, twin):
        _write(save, _with_columns(twin, entries, mapping.dialect, guesses))
        typer.echo(f"written: [columns] of {twin}")
        return
    story = f"Columns of {recording.name}, for {twin.name}"
    _write(save, column_file_text(entries, mapping.dialect, guesses, story))
    typer.echo(f"written: {save}; to use it, put this line above the tables of {twin}:")
    typer.echo(f'columns = "{_relative(save, twin)}"')


def _with_columns(
    twin: Path, entries: Mapping[str, MappedColumn], dialect: str, guesses: Mapping[str, str]
) -> str:
    """Text of the twin file with these columns; it loads."""
    from gmfbo.sources.twin_file.columns_in_twin import with_columns
    from gmfbo.sources.twin_file.twin_file import TwinFile

    # As bytes, since reading as text would change the line ends of the whole file.
    text = with_columns(twin.read_bytes().decode("utf-8"), entries, dialect, guesses)
    TwinFile.parse(text, twin.name, twin.parent)
    return text


def _is_twin(save: Path, twin: Path) -> bool:
    return save.exists() and save.samefile(twin)


def _check_target(save: Path, twin: Path) -> None:
    """Refuse a file that would be lost: one that is there and holds no column mapping."""
    from gmfbo.errors import TwinFileError
    from gmfbo.sources.twin_file.column_file import ColumnFile

    if not save.exists() or _is_twin(save, twin):
        return
    try:
        ColumnFile.read(save)
    except TwinFileError as error:
        raise InputError(
            f"--save: '{save}' is there and would be lost, since it is no column mapping: {error}; "
            f"give a new name, or {twin} itself"
        ) from None


def _write(path: Path, text: str) -> None:
    from gmfbo.files.durable import cause, write_whole

    try:
        write_whole(path, text.encode("utf-8"))
    except OSError as error:
        raise InputError(f"--save: cannot write '{path}': {cause(error)}") from None


def _relative(save: Path, twin: Path) -> str:
    import os

    return Path(os.path.relpath(save.resolve(), twin.resolve().parent)).as_posix()
