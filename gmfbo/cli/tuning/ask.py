"""`gmfbo ask`: the next gains, for the user who runs the axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import console, parse_settings
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.first_runs import RandomStart, confirm_first_runs

if TYPE_CHECKING:
    from gmfbo import Tuner
    from gmfbo.tuning.query.request import TrialRequest


MANUAL = Manual(
    files={
        "STUDY.study/": "the study, made at the first call",
        "STUDY.study/next.csv": "the reference to play; next1.csv, next2.csv ... of several",
        "STUDY.study/next.json": "trial, gains with all digits, and the files to play",
        "STUDY.study/next/5.csv, 5.json": "the same of trial 5, with --parallel",
    },
    examples={
        "The next run:": "gmfbo ask monday.toml",
        "Three runs at once, for three benches or one afternoon:": (
            "gmfbo ask monday.toml --parallel 3"
        ),
        "With one gain held, for a script:": "gmfbo ask monday.toml --fix ctl.Kd=3 --json",
    },
    see_also=("gmfbo tell", "gmfbo tune", "notebooks/docs/bench.md"),
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
    parallel: Annotated[
        int | None,
        typer.Option(
            "--parallel",
            metavar="N",
            min=1,
            help="Runs to ask for at once; those not told yet count, and are printed again.",
        ),
    ] = None,
    json: Annotated[
        bool,
        typer.Option(
            "--json",
            help="Print trial, gains, references and note as JSON, with --parallel a list of "
            "them; null when all is done.",
        ),
    ] = False,
    random_start: RandomStart = False,
) -> None:
    """Print the next gains to try, for whoever runs the axis.

    Runs the twin as the method wants it, then asks for one real run, or for several at once.
    Asking again before telling prints the same gains, also after a restart.
    """
    from gmfbo import Tuner
    from gmfbo.cli.tuning.study_display import StudyDisplay
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.told.next_run import write_next_run

    asked = Study.read(study)
    confirm_first_runs(asked, random_start)
    with Tuner(asked) as tuner:
        with StudyDisplay(console, asked.file.budget.is1_runs, tuner.history.first_runs) as display:
            tuner.watch(None if json else display.show)
            requests = _asked(tuner, parse_settings(fix or [], option="--fix"), parallel)
        if not requests:
            return _print_end(tuner, json)
        several = parallel is not None
        for request in requests:
            write_next_run(asked.location, request, tuner.experiment.references, parallel=several)
        if json:
            typer.echo(_as_json(requests, len(tuner.experiment.parts), several))
        else:
            _print_requests(tuner, requests, study, several)


def _print_end(tuner: Tuner, json: bool) -> None:
    """Say that there is nothing more to ask, and what the study came to."""
    from gmfbo.cli.tuning.study_result import (
        print_next_step,
        print_result,
        refuse_without_success,
    )
    from gmfbo.tuning.told.next_run import remove_next_run

    remove_next_run(tuner.study.location, len(tuner.experiment.parts))
    result = tuner.result()
    if json:
        typer.echo("null")
        return
    typer.echo("the budget is used up: nothing more to try")
    print_result(tuner.study, result)
    refuse_without_success(result)
    print_next_step(tuner.study, result)


def _asked(tuner: Tuner, held: Mapping[str, float], parallel: int | None) -> Sequence[TrialRequest]:
    if parallel is not None:
        return tuner.ask(held, parallel=parallel)
    request = tuner.ask(held)
    return [] if request is None else [request]


def _as_json(requests: Sequence[TrialRequest], count: int, several: bool) -> str:
    from gmfbo.tuning.told.next_run import next_run

    told = [next_run(request, count, parallel=several) for request in requests]
    return dumps(told if several else told[0], indent=1)


def _print_requests(
    tuner: Tuner, requests: Sequence[TrialRequest], study: Path, several: bool
) -> None:
    """Print the requested runs, and name those that are waited for beside them."""
    for place, request in enumerate(requests):
        _print_request(tuner, request, study, place if several else None)
    others = [one.number for one in tuner.waiting if one not in requests]
    if others:
        numbers = ", ".join(str(number) for number in others)
        typer.echo(f"waited for   also trial {numbers}: gmfbo ask --parallel {len(tuner.waiting)}")


def _print_request(tuner: Tuner, request: TrialRequest, study: Path, place: int | None) -> None:
    """Print one requested run; `place` counts those that were asked for at once."""
    from gmfbo.tuning.told.next_run import NEXT, PARALLEL, reference_files

    budget, made = tuner.study.file.budget, tuner.history.made + (place or 0)
    most = f" of {budget.is1_runs}" if budget.is1_runs is not None else ""
    typer.echo(f"trial {request.number}, real run {made + 1}{most}")
    for name, value in request.gains.items():
        typer.echo(f"set          {name} = {value:.6g}")
    parts, folder = tuner.experiment.parts, tuner.study.location
    trial = None if place is None else request.number
    for name, part in zip(reference_files(len(parts), trial), parts, strict=True):
        typer.echo(f"play         {folder / name}: {part.described}")
        end = part.begin + part.horizon
        typer.echo(f"record       {part.signal}, until {end:g} s or longer")
    written = NEXT if trial is None else f"{PARALLEL}/{trial}.json"
    typer.echo(f"written      {folder / written}, with all digits")
    wanted = " ".join(["RECORDING"] * len(parts))
    which = "" if trial is None else f"--trial {trial} "
    typer.echo(f"then         gmfbo tell {study} {which}{wanted}")
    if request.note:
        typer.echo(f"note         {request.note}")
