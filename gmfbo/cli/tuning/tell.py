"""`gmfbo tell`: read the recording of the requested run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import gains_text, parse_settings
from gmfbo.cli.manual import Manual
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
        "The same trial again, since the gains are not to blame:": (
            "gmfbo tell monday.toml --failed 'door was open' --not-the-gains"
        ),
        "One of several that were asked for:": "gmfbo tell monday.toml --trial 6 run6.csv",
        "The last one was told by mistake:": "gmfbo tell monday.toml --undo",
    },
    see_also=("gmfbo ask", "notebooks/docs/bench.md", "notebooks/docs/recordings.md"),
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

NotTheGains = Annotated[
    bool,
    typer.Option(
        "--not-the-gains",
        help="With --failed: the gains are not the reason; the same trial is asked again.",
    ),
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
    not_the_gains: NotTheGains = False,
) -> None:
    """Take back the recording of the run that `gmfbo ask` wanted.

    Its gains are those in its lines `# NAME = VALUE`, those of --set, or those asked for. A run
    that failed ranks below all others, and gains near it are avoided.
    """
    from gmfbo.tuning.study.study import Study

    if not_the_gains and failed is None:
        raise InputError("--not-the-gains: expected --failed WHY beside it; give the reason")
    if [bool(recordings), failed is not None, undo].count(True) != 1:
        raise InputError("expected a recording, --failed WHY or --undo; give one of them")
    told = Study.read(study)
    if undo:
        _take_back(told)
    elif not_the_gains:
        _ask_again(told, study, failed or "failed", trial)
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
    from gmfbo.sources.plants.failed_run import failed_run
    from gmfbo.tuning.told.next_run import remove_next_run

    with _waiting_tuner(told, study) as tuner:
        waited = {request.number: request for request in tuner.waiting}
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


def _ask_again(told: Study, study: Path, why: str, number: int | None) -> None:
    """Ask again for a run that failed, but not because of its gains."""
    with _waiting_tuner(told, study) as tuner:
        again = tuner.not_the_gains(number, why)
    typer.echo(f"trial {again.number}: nothing is learned from it; play it again")


def _waiting_tuner(told: Study, study: Path) -> Tuner:
    """Open a study that waits for a run."""
    from gmfbo import Tuner

    if not told.begun:
        raise InputError(f"{study}: nothing was asked for; run 'gmfbo ask {study}' first")
    tuner = Tuner(told)
    if not tuner.waiting:
        tuner.close()
        raise InputError(f"{study}: no run is waited for; run 'gmfbo ask {study}' first")
    return tuner


def _print_told(tuner: Tuner, request: TrialRequest, trial: Trial, *, named: bool) -> None:
    from gmfbo.cli.tuning.study_result import metric_lines
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
        settled = tuner.history.settled or not tuner.history.ranked
        label = "best so far" if settled else "least bad"
        typer.echo(f"{label:<12} trial {best.number}: {gains_text(best.gains)}")
        typer.echo(f"             objective {best.objective:.4f}")
