"""`gmfbo tune`: a tuning study, shown while it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import LivePage
from gmfbo.cli.arguments import StudyFile as StudyPath
from gmfbo.cli.console import console, gains_text
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.objective_text import metric_text, objective_table
from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metrics import METRICS
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from gmfbo.recordings.store.trial import Trial
    from gmfbo.reports.study.review import StudyReview
    from gmfbo.tuning.query.progress import Progress
    from gmfbo.tuning.query.request import TuningResult
    from gmfbo.tuning.study.study import Study
    from gmfbo.tuning.study_file.study_sections import StudyFile


MANUAL = Manual(
    files={
        "STUDY.study/": "study.toml, trials/000001.h5 and so on, events.jsonl, index.h5; beside "
        "the study file unless that says 'out'",
        "PAGE": "of --html: a page that reloads itself; open it as a file, no server is needed",
    },
    examples={
        "Tune:": "gmfbo tune joint.toml",
        "Tune, and see in a browser how it goes:": "gmfbo tune joint.toml --html joint.html",
        "Go on after Ctrl-C, a kill or a power cut, with the same gains as without it:": (
            "gmfbo tune joint.toml --resume"
        ),
    },
    exits={0: "done, also where single real runs failed: they are priced as the worst"},
    see_also=(
        "gmfbo watch",
        "gmfbo report",
        "gmfbo ask",
        "gmfbo compare",
        "gmfbo methods",
        "notebooks/docs/tuning.md",
        "notebooks/docs/studies.md",
    ),
)


def tune(
    study: StudyPath,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a study that was stopped or killed.")
    ] = False,
    html: LivePage = None,
) -> None:
    """Run a tuning study; every trajectory is kept.

    The study file names the real axis (an FMU, a program or a folder of recordings), its twin,
    the box of gains, the reference and the budget of real runs. Best observed gains and,
    separately, the recommended ones are printed at the end. The objective is minimised.
    """
    from gmfbo.tuning.study.study import Study

    opened = Study.read(study)
    try:
        run_study(opened, resume=resume, html=html)
    except KeyboardInterrupt:
        if opened.trials:
            console.print(f"'gmfbo tune {study} --resume' goes on with it", markup=False)
        raise


def run_study(study: Study, *, resume: bool, html: Path | None = None) -> TuningResult:
    """Run a study with its progress on the terminal, and print its result.

    Parameters
    ----------
    study : Study
        Not begun, or with `resume` stopped.
    resume : bool
        Go on where it was stopped.
    html : Path, optional
        Page that is kept up to date while the study runs.

    Returns
    -------
    TuningResult
        Best observed gains and, separately, the recommended ones.
    """
    from gmfbo import Tuner
    from gmfbo.cli.tuning.live_study import LiveStudy
    from gmfbo.cli.tuning.study_display import StudyDisplay
    from gmfbo.interrupt import remembered_interrupt

    live = LiveStudy.begin(html)
    with (
        Tuner(study, resume=resume) as tuner,
        live.following(study.location),
        remembered_interrupt() as pressed,
    ):
        budget = study.file.budget
        display = StudyDisplay(console, budget.is1_runs, tuner.history.first_runs)

        def show(step: Progress) -> None:
            if pressed.is_set():
                raise KeyboardInterrupt
            display.show(step)
            live.show()

        with display:
            result = tuner.run(show)
    print_result(study, result)
    return result


def print_result(study: Study | StudyReview, result: TuningResult) -> None:
    """Print the best gains of a study."""
    console.print(
        f"{study.file.name}: {study.file.method}, {result.is1_runs} real runs, "
        f"{result.is2_runs} of the twin (initial ones included), "
        f"{result.queries} queries after the initial data, "
        f"cost {result.cost:.1f} (a twin run counts 0.1)"
    )
    if result.earlier:
        left = f", {result.left_out} at other gains left out" if result.left_out else ""
        runs = f"{result.earlier} real runs of {study.file.earlier}{left}"
        console.print(f"taken over         {runs}", markup=False)
    for drift in result.drifts:
        console.print(f"plant changed      {drift.message}")
    for number, reason in enumerate(result.twin_versions, start=1):
        console.print(f"twin version {number:<6}{reason}", markup=False)
    if result.best is None:
        console.print("no real run succeeded, so there are no gains to take")
    else:
        console.print(f"best observed      {gains_text(result.best.gains)}")
        console.print(f"                   objective {result.best.objective:.4f}")
        _print_metrics(study, result.best)
    if result.recommendation is not None:
        advised = result.recommendation
        console.print(f"model recommends   {gains_text(advised.gains)}")
        console.print(f"                   expected {advised.mean:.4f} +- {advised.std:.4f}")
    console.print(f"study folder       {study.location}")


def _print_metrics(study: Study | StudyReview, best: Trial) -> None:
    """Print the metrics of a run, and what those that are weighted count."""
    units, objective = study.metric_units, study.objective
    for name in shown_metrics(study.file, best.metrics):
        told = metric_text(name, best.metrics[name], units)
        console.print(f"                   {words(name):<15} {told}", markup=False)
    if objective is not None:
        normalise = study.file.objective.normalise
        given = normalise.points is None
        samples = "the study file" if given else f"{normalise.points} twin runs"
        for line in objective_table(objective, best.metrics, units, samples):
            console.print(line, markup=False)


def shown_metrics(file: StudyFile, metrics: Mapping[str, float]) -> list[str]:
    """Metrics worth a line: all without a weight or limit of theirs stay in the report.

    Parameters
    ----------
    file : StudyFile
        With weights and limits.
    metrics : mapping of str to float
        Of a run.
    """
    wanted = {*METRICS, *file.objective.weights, *file.constraints, *file.own_metrics}
    ours = {*TRACKING_METRICS, *COMMAND_METRICS, *MARGINS}
    return [n for n in metrics if (base := n.partition("[")[0]) in wanted or base not in ours]
