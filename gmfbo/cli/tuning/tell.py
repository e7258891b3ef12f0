"""`gmfbo tell`: read the recording of the requested run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import gains_text, parse_settings
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.objective_text import metric_text
from gmfbo.cli.tuning.tune import shown_metrics
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo import Tuner
    from gmfbo.recordings.store.trial import Trial
    from gmfbo.tuning.query.request import TrialRequest
    from gmfbo.tuning.study.study import Study


MANUAL = Manual(
    files={
        "STUDY.study/": "the trial; the files that asked for it are removed",
    },
    examples={
        "What was measured at the gains that were asked for:": "gmfbo tell monday.toml run5.csv",
        "At others:": "gmfbo tell monday.toml run5.csv --set ctl.Kp=90 --anyway",
        "A run without a recording:": "gmfbo tell monday.toml --failed 'lost the encoder'",
        "One of several that were asked for:": "gmfbo tell monday.toml --trial 6 run6.csv",
        "The last one was told by mistake:": "gmfbo tell monday.toml --undo",
    },
    see_also=("gmfbo ask", "notebooks/docs/studies.md", "notebooks/docs/recordings.md"),
)


TrialNumber = Annotated[
    int | None,
    typer.Option(
        "--trial",
        metavar="NUMBER",
        help="Run that was recorded, where several are waited for; without it the one whose "
        "gains the recording states.",
    ),
]

Undo = Annotated[
    bool,
    typer.Option(
        "--undo",
        help="Take back the run that was told last: it stays on disk, counts no more, and its "
        "gains are asked for again.",
    ),
]

Failed = Annotated[
    str | None,
    typer.Option("--failed", metavar="WHY", help="The run failed; say why in a few words."),
]


def tell(
    study: StudyFile,
    recordings: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[REC]...", help="What was measured, a file a reference; none with --failed."
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Gain in force [unit of the FMU parameter], whatever the recording says; may be "
            "repeated.",
        ),
    ] = None,
    anyway: Annotated[
        bool,
        typer.Option(
            "--anyway",
            help="Take it though its gains or its reference differ, or a second time.",
        ),
    ] = False,
    trial: TrialNumber = None,
    undo: Undo = False,
    failed: Failed = None,
) -> None:
    """Take back the recording of the run that `gmfbo ask` wanted.

    The gains of a recording are those in its lines `# NAME = VALUE`, those of --set, or those
    asked for. A run that failed is priced as the worst one.
    """
    from gmfbo.tuning.study.study import Study

    if [bool(recordings), failed is not None, undo].count(True) != 1:
        raise InputError("expected a recording, --failed WHY or --undo; give one of them")
    told = Study.read(study)
    if undo:
        _take_back(told)
    else:
        _tell(
            told, study, recordings or failed or "failed", trial, parse_settings(set_ or []), anyway
        )
    typer.echo(f"then         gmfbo ask {study}")


def _tell(
    told: Study,
    study: Path,
    what: list[Path] | str,
    number: int | None,
    given: Mapping[str, float],
    anyway: bool,
) -> None:
    """Tell recordings, or why a run failed, of one of the runs that are waited for."""
    from gmfbo import Tuner
    from gmfbo.sources.plants.failed_run import failed_run
    from gmfbo.tuning.told.next_run import remove_next_run

    if not told.begun:
        raise InputError(f"{study}: nothing was asked for; run 'gmfbo ask {study}' first")
    with Tuner(told) as tuner:
        waited = {request.number: request for request in tuner.waiting}
        if not waited:
            raise InputError(f"{study}: no run is waited for; run 'gmfbo ask {study}' first")
        failed = failed_run(tuner.experiment.reference, what) if isinstance(what, str) else None
        run = what if failed is None else failed
        made = tuner.tell(number, run, gains=given, anyway=anyway)
        remove_next_run(told.location, len(tuner.experiment.parts), made.number)
        _print_told(tuner, waited[made.number], made, named=bool(given) or failed is not None)


def _take_back(told: Study) -> None:
    from gmfbo.tuning.told.next_run import remove_next_run
    from gmfbo.tuning.told.undo import take_back

    back = take_back(told)
    remove_next_run(told.location, len(told.file.references))
    twin = f" and {back.followers} twin runs made because of it" if back.followers else ""
    typer.echo(f"taken back   trial {back.trial.number}{twin}: on disk, but counted no more")
    typer.echo(f"again        trial {back.again}: {gains_text(back.trial.gains)}")


def _print_told(tuner: Tuner, request: TrialRequest, trial: Trial, *, named: bool) -> None:
    budget, made = tuner.study.file.budget, tuner.history.made
    most = f" of {budget.is1_runs}" if budget.is1_runs is not None else ""
    how = "" if trial.status == "ok" else f" ({trial.status})"
    typer.echo(f"trial {trial.number}, real run {made}{most}: objective {trial.objective:.4f}{how}")
    if trial.gains != request.gains:
        typer.echo(f"taken at     {gains_text(trial.gains)}")
        typer.echo(f"instead of   {gains_text(request.gains)}")
    elif not named and not any(name in trial.recording.parameters for name in trial.gains):
        typer.echo("gains        as asked for: the recording does not name its own")
    units = tuner.study.metric_units
    for name in shown_metrics(tuner.study.file, trial.metrics) if trial.status == "ok" else ():
        told_as = metric_text(name, trial.metrics[name], units)
        typer.echo(f"{name.replace('_', ' '):<12} {told_as}")
    if (best := tuner.history.best) is not None:
        typer.echo(f"best so far  trial {best.number}: {gains_text(best.gains)}")
        typer.echo(f"             objective {best.objective:.4f}")
