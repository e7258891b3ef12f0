"""`gmfbo ask`: the next gains, for the user who runs the axis."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import console, parse_settings
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.first_runs import RandomStart, confirm_first_runs
from gmfbo.cli.tuning.study_result import print_result, refuse_without_success

if TYPE_CHECKING:
    from gmfbo import Tuner
    from gmfbo.tuning.query.request import TrialRequest


MANUAL = Manual(
    files={
        "STUDY.study/": "the study, made at the first call",
        "STUDY.study/next.csv": "the reference to play; next1.csv, next2.csv ... of several",
        "STUDY.study/next.json": "trial, gains with all digits, and the files to play",
    },
    examples={
        "The next run:": "gmfbo ask monday.toml",
        "With one gain held, for a script:": "gmfbo ask monday.toml --fix ctl.Kd=3 --json",
    },
    see_also=("gmfbo tell", "gmfbo tune", "notebooks/docs/studies.md"),
)


def ask(
    study: StudyFile,
    fix: Annotated[
        list[str] | None,
        typer.Option(
            "--fix",
            metavar="NAME=VALUE",
            help="Hold a gain in this proposal [unit of the FMU parameter]; may be repeated.",
        ),
    ] = None,
    json: Annotated[
        bool,
        typer.Option(
            "--json", help="Print trial, gains and references as JSON; null when all is done."
        ),
    ] = False,
    random_start: RandomStart = False,
) -> None:
    """Print the next gains to try, for whoever runs the axis.

    Runs the twin as the method wants it, then asks for one real run. Asking again before telling
    prints the same gains, also after a restart.
    """
    from gmfbo import Tuner
    from gmfbo.cli.tuning.study_display import StudyDisplay
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.told.next_run import next_run_text, remove_next_run, write_next_run

    asked = Study.read(study)
    confirm_first_runs(asked, random_start)
    display = StudyDisplay(console, asked.file.budget.is1_runs)
    with Tuner(asked) as tuner:
        with display:
            tuner.watch(None if json else display.show)
            request = tuner.ask(parse_settings(fix or [], option="--fix"))
        if request is None:
            remove_next_run(asked.location, len(tuner.experiment.parts))
            if json:
                typer.echo("null")
            else:
                typer.echo("the budget is used up: nothing more to try")
                result = tuner.result()
                print_result(asked, result)
                refuse_without_success(result)
            return
        write_next_run(asked.location, request, tuner.experiment.references)
        if json:
            typer.echo(next_run_text(request, len(tuner.experiment.parts)))
        else:
            _print_request(tuner, request, study)


def _print_request(tuner: Tuner, request: TrialRequest, study: Path) -> None:
    from gmfbo.tuning.told.next_run import NEXT, reference_files

    budget, made = tuner.study.file.budget, tuner.history.made
    most = f" of {budget.is1_runs}" if budget.is1_runs is not None else ""
    typer.echo(f"trial {request.number}, real run {made + 1}{most}")
    for name, value in request.gains.items():
        typer.echo(f"set          {name} = {value:.6g}")
    parts, folder = tuner.experiment.parts, tuner.study.location
    for name, part in zip(reference_files(len(parts)), parts, strict=True):
        (signal,) = part.reference.signals
        unit = part.reference.units.get(signal, "")
        to = f"{part.initial:g} to {part.initial + part.step_size:g} {unit}".strip()
        typer.echo(f"play         {folder / name}: {signal} from {to} at {part.step_time:g} s")
        end = part.step_time + part.horizon
        typer.echo(f"record       {part.signal}, until {end:g} s or longer")
    typer.echo(f"written      {folder / NEXT}, with all digits")
    wanted = " ".join(["RECORDING"] * len(parts))
    typer.echo(f"then         gmfbo tell {study} {wanted}")
    if request.note:
        typer.echo(f"note         {request.note}")
