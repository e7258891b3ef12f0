"""Options by which a person says which column of a logger's file is which signal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.completion import dialects, presets
from gmfbo.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from gmfbo.recordings.columns.column_mapping import MappedColumn

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=COLUMN",
        help="Signal and its column, 'position=ActPos [deg]'; may be repeated.",
    ),
]

DialectName = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="How a text file is written: auto, plain, decimal_comma, twincat_scope.",
        autocompletion=dialects,
    ),
]

SampleTime = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="Time between two rows, where the file has no clock."),
]

PresetName = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Columns of a known logger: halsampler, odrive, twincat_scope, vesc.",
        autocompletion=presets,
    ),
]


def column_settings(texts: list[str]) -> dict[str, MappedColumn]:
    """Columns by name from `NAME=COLUMN [unit]` arguments.

    Parameters
    ----------
    texts : list of str
        The arguments.

    Raises
    ------
    InputError
        One is not of that form.
    """
    from gmfbo.recordings.columns.column_mapping import MappedColumn
    from gmfbo.recordings.csv.header import split_unit

    settings = {}
    for text in texts:
        name, equals, column = (part.strip() for part in text.partition("="))
        if not (equals and name and column):
            raise InputError(f"--set: expected NAME=COLUMN, such as position=ActPos, got '{text}'")
        plain, unit = split_unit(column)
        settings[name] = MappedColumn(plain, unit)
    return settings


def counted_rows(sample_time: float | None) -> dict[str, MappedColumn]:
    """Entry of a clock that counts rows; empty where the file has a clock.

    Parameters
    ----------
    sample_time : float or None
        [s] Between two rows.

    Raises
    ------
    InputError
        It is not above zero.
    """
    from gmfbo.recordings.columns.column_mapping import MappedColumn

    if sample_time is None:
        return {}
    if not 0.0 < sample_time < float("inf"):
        raise InputError(f"--sample-time: expected seconds above 0, got {sample_time:g}")
    return {"time": MappedColumn("", sample_time=sample_time)}


def check_dialect(dialect: str | None) -> None:
    """Raise InputError for a dialect that does not exist."""
    from gmfbo.recordings.columns.column_mapping import DIALECTS

    if dialect is not None and dialect not in DIALECTS:
        raise InputError(f"--dialect: no dialect '{dialect}'" + did_you_mean(dialect, DIALECTS))
