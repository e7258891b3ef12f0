"""`gmfbo tune`: a tuning study, shown while it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import LivePage, StudyFile
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.first_runs import RandomStart, confirm_first_runs

if TYPE_CHECKING:
    from pathlib import Path

    from gmfbo.tuning.query.progress import Progress
    from gmfbo.tuning.query.request import TuningResult
    from gmfbo.tuning.study.study import Study


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
    exits={
        0: "done, also where single real runs failed",
        3: "no real run succeeded, or a simulation failed",
    },
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
    study: StudyFile,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a study that was stopped or killed.")
    ] = False,
    html: LivePage = None,
    random_start: RandomStart = False,
) -> None:
    """Run a tuning study; every trajectory is kept.

    The study file names the real axis (an FMU, a program or a folder of recordings), its twin,
    the box of gains, the reference and the budget of real runs. The recommended gains and,
    separately, the best observed ones are printed at the end. The objective is minimised.
    """
    from gmfbo.cli.tuning.study_result import refuse_without_success
    from gmfbo.tuning.study.study import Study

    asked = Study.read(study)
    confirm_first_runs(asked, random_start)
    try:
        result = run_study(asked, resume=resume, html=html)
    except KeyboardInterrupt:
        if asked.trials:
            console.print(f"'gmfbo tune {study} --resume' goes on with it", markup=False)
        raise
    refuse_without_success(result)


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
    from gmfbo.cli.tuning.study_result import print_next_step, print_result
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
    print_next_step(study, result)
    return result
