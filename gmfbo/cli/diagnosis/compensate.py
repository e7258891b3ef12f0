"""`gmfbo compensate`: write the diagnosed feed-forward for a drive."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.manual import Manual
from gmfbo.errors import InputError
from gmfbo.plain_words import wrapped

if TYPE_CHECKING:
    from gmfbo.diagnosis.compensation.table import Compensation

INDENT = 15

MANUAL = Manual(
    files={
        "FILE": "table over the state (.csv), functions without dependencies (.c), or function "
        "blocks of IEC 61131-3 (.st)"
    },
    examples={
        "As C, for the drive's own language:": "gmfbo compensate found --out friction.c",
        "As a table, smoothed within 0.05 rad/s:": (
            "gmfbo compensate found --out friction.csv --smoothing 0.05"
        ),
        "As a function block for a PLC:": "gmfbo compensate found --out friction.st",
    },
    exits={2: "bad input, or nothing that was found can be cancelled"},
    see_also=("gmfbo diagnose", "gmfbo experiment", "notebooks/docs/after_a_diagnosis.md"),
)


def compensate(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder that 'gmfbo diagnose' wrote.")
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            help="To write: .csv for a table, .c for C functions, .st for Structured Text.",
        ),
    ],
    smoothing: Annotated[
        float | None,
        typer.Option(
            metavar="VELOCITY",
            help="Velocity [rad/s or m/s] within which the sign of friction is smoothed; 1 % of "
            "the fastest recorded motion without it.",
        ),
    ] = None,
) -> None:
    """Write what a drive adds to cancel the physics that was found.

    What is added has the opposite sign of the effect: torque [N.m] or force [N] at the motor
    shaft, command [its unit], or position reference [rad or m]. It says what it leaves out, and
    why: no feed-forward cancels a delay, a limit or a fault of the sensor.
    """
    ending = out.suffix.lower()
    if ending not in (".csv", ".c", ".st"):
        raise InputError(f"--out: expected a file ending in .csv, .c or .st, got '{out}'")

    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.compensation.compensation import compensation_of
    from gmfbo.diagnosis.compensation.structured_text import structured_text
    from gmfbo.diagnosis.compensation.text import c_text, csv_text, formula, target_words
    from gmfbo.diagnosis.result.diagnosis_json import read_diagnosis
    from gmfbo.files.durable import cause, write_whole
    from gmfbo.plain_words import words

    # What version 0.1 found can be cancelled as well.
    found = read_diagnosis(Diagnosis, folder, also=(1,))
    made = compensation_of(found, str(folder), smoothing)
    write = {".csv": csv_text, ".c": c_text, ".st": structured_text}[ending]
    try:
        write_whole(out, write(made).encode("utf-8"))
    except OSError as error:
        raise InputError(f"--out: cannot write '{out}': {cause(error)}") from None
    for target in made.targets:
        _say("add to", f"{target_words(made, target)}: {formula(made, target)}")
    _say_tables(made)
    for remark in made.remarks:
        _say("note", remark)
    for entry in made.not_compensated:
        _say("not in it", f"{words(entry.effect)}: {entry.advice}")
    _say("written", str(out))


def _say_tables(made: Compensation) -> None:
    from gmfbo.plain_words import number, words
    from gmfbo.units import unit_words

    for table in made.tables:
        ends = f"{number(float(table.y.min()))} to {number(float(table.y.max()))}"
        covered = f"{number(float(table.x[0]))} to {number(float(table.x[-1]))}"
        again = ", repeating" if table.period else ""
        _say(
            "table",
            f"{words(table.effect)}: {ends} {unit_words(table.unit_y)} over the {table.over} from "
            f"{covered} {table.unit_x}{again}, {table.x.size} rows",
        )
        if table.remark:
            _say("", table.remark)


def _say(head: str, text: str) -> None:
    for line in wrapped(text, f"{head:<{INDENT}}"):
        typer.echo(line)
