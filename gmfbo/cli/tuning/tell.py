"""`gmfbo tell`: read the recording of the requested run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import gains_text, parse_settings
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.study_result import metric_lines
from gmfbo.errors import InputError

if TYPE_CHECKING:
    from gmfbo import Tuner
    from gmfbo.recordings.store.trial import Trial
    from gmfbo.tuning.query.request import TrialRequest


MANUAL = Manual(
    files={
        "STUDY.study/": "the trial; next.csv and next.json are removed",
    },
    examples={
        "What was measured at the gains that were asked for:": "gmfbo tell monday.toml run5.csv",
        "At others:": "gmfbo tell monday.toml run5.csv --set ctl.Kp=90 --anyway",
        "A run without a recording:": "gmfbo tell monday.toml --failed 'lost the encoder'",
        "The same trial again, since the gains are not to blame:": (
            "gmfbo tell monday.toml --failed 'door was open' --not-the-gains"
        ),
    },
    see_also=("gmfbo ask", "notebooks/docs/studies.md", "notebooks/docs/recordings.md"),
)


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
        typer.Option("--anyway", help="Take it though its gains differ, or a second time."),
    ] = False,
    failed: Annotated[
        str | None,
        typer.Option("--failed", metavar="WHY", help="The run failed; say why in a few words."),
    ] = None,
    not_the_gains: Annotated[
        bool,
        typer.Option(
            "--not-the-gains",
            help="With --failed: the gains are not the reason; the same trial is asked again.",
        ),
    ] = False,
) -> None:
    """Take back the recording of the run that `gmfbo ask` wanted.

    Its gains are those in its lines `# NAME = VALUE`, those of --set, or those asked for. A run
    that failed ranks below all others, and gains near it are avoided.
    """
    from gmfbo import Tuner
    from gmfbo.sources.plants.failed_run import failed_run
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.told.next_run import remove_next_run

    _check_arguments(recordings, failed, not_the_gains)
    told = Study.read(study)
    if not told.begun:
        raise InputError(f"{study}: nothing was asked for; run 'gmfbo ask {study}' first")
    given = parse_settings(set_ or [])
    with Tuner(told) as tuner:
        request = tuner.pending
        if request is None or request.source != "IS1":
            raise InputError(f"{study}: no run is waited for; run 'gmfbo ask {study}' first")
        if not_the_gains:
            return _print_again(tuner, request, failed or "failed")
        run = recordings or failed_run(tuner.experiment.reference, failed or "failed")
        trial = tuner.tell(request, run, gains=given, anyway=anyway)
        remove_next_run(told.location, len(tuner.experiment.parts))
        _print_told(tuner, request, trial, named=bool(given) or not recordings)
    typer.echo(f"then         gmfbo ask {study}")


def _print_again(tuner: Tuner, request: TrialRequest, why: str) -> None:
    tuner.not_the_gains(request, why)
    typer.echo(f"trial {request.number}: nothing is learned from it; play it again")


def _check_arguments(
    recordings: list[Path] | None, failed: str | None, not_the_gains: bool
) -> None:
    if not_the_gains and failed is None:
        raise InputError("--not-the-gains: expected --failed WHY beside it; give the reason")
    if bool(recordings) == (failed is not None):
        raise InputError("expected either a recording or --failed WHY; give one of them")


def _print_told(tuner: Tuner, request: TrialRequest, trial: Trial, *, named: bool) -> None:
    from gmfbo.tuning.history.incumbent import has_settled

    budget, made = tuner.study.file.budget, tuner.history.made
    most = f" of {budget.is1_runs}" if budget.is1_runs is not None else ""
    how = "" if trial.status == "ok" else f" ({trial.status})"
    typer.echo(f"trial {trial.number}, real run {made}{most}: objective {trial.objective:.4f}{how}")
    if trial.gains != request.gains:
        typer.echo(f"taken at     {gains_text(trial.gains)}")
        typer.echo(f"instead of   {gains_text(request.gains)}")
    elif not named and not any(name in trial.recording.parameters for name in trial.gains):
        typer.echo("gains        as asked for: the recording does not name its own")
    for line in metric_lines(tuner.study, trial) if trial.status == "ok" else ():
        typer.echo(line)
    if trial.status == "ok" and not has_settled(trial):
        typer.echo("not settled: it ranks below each run that settled")
    if (best := tuner.history.best) is not None:
        typer.echo(f"best so far  trial {best.number}: {gains_text(best.gains)}")
        typer.echo(f"             objective {best.objective:.4f}")
