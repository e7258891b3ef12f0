"""Ask before a real axis is run at random gains."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo.tuning.study.study import Study

RandomStart = Annotated[
    bool,
    typer.Option(
        "--random-start", help="Let the first real runs be random points of the box of gains."
    ),
]


def confirm_first_runs(study: Study, random_start: bool) -> None:
    """Ask whether a new study of a real axis may begin at random points of the box.

    Nothing is asked where the file names the gains in force, known-safe gains or an earlier
    study, where an FMU or recordings play the axis, or where the study has begun.

    Parameters
    ----------
    study : Study
        About to be run.
    random_start : bool
        The answer, where it was given beforehand.

    Raises
    ------
    InputError
        The answer was no, or there is nobody to ask.
    """
    file = study.file
    real = file.is1.command is not None or file.is1.function is not None or file.is1.ask_tell
    known = file.safety.start or file.earlier or any(g.now is not None for g in file.gains.values())
    if random_start or not real or known or study.begun:
        return
    count = file.budget.initial_is1
    first = (
        "first real run is a random point"
        if count == 1
        else (f"first {count} real runs are random points")
    )
    box = ", ".join(f"{name} in [{gain.low:g}, {gain.high:g}]" for name, gain in file.gains.items())
    said = f"the {first} of the box ({box or 'that of the twin file'})"
    if sys.stdin.isatty() and typer.confirm(f"{said}; play them?"):
        return
    raise InputError(
        f"{said}; name the gains in force in [gains], NAME = {{ low = .., high = .., now = .. }}, "
        "or allow it with --random-start"
    )
