"""`gmfbo tune`: a tuning study, shown while it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import StudyFile
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual
from gmfbo.cli.tuning.first_runs import RandomStart, confirm_first_runs
from gmfbo.cli.tuning.study_result import print_result, refuse_without_success

if TYPE_CHECKING:
    from gmfbo.tuning.query.progress import Progress
    from gmfbo.tuning.query.request import TuningResult
    from gmfbo.tuning.study.study import Study


MANUAL = Manual(
    files={
        "STUDY.study/": "study.toml, trials/000001.h5 and so on, events.jsonl, index.h5; beside "
        "the study file unless that says 'out'",
    },
    examples={
        "Tune:": "gmfbo tune joint.toml",
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
    random_start: RandomStart = False,
) -> None:
    """Run a tuning study; every trajectory of every source is kept.

    The study file names the real axis (an FMU, a program or a folder of recordings), its twin,
    the box of gains, the reference and the budget of real runs. The recommended gains and,
    separately, the best observed ones are printed at the end. The objective is minimised.
    """
    from gmfbo.tuning.study.study import Study

    asked = Study.read(study)
    confirm_first_runs(asked, random_start)
    refuse_without_success(run_study(asked, resume=resume))


def run_study(study: Study, *, resume: bool) -> TuningResult:
    """Run a study with its progress on the terminal, and print its result.

    Parameters
    ----------
    study : Study
        Not begun, or with `resume` stopped.
    resume : bool
        Go on where it was stopped.

    Returns
    -------
    TuningResult
        Best observed gains and, separately, the recommended ones.
    """
    from gmfbo import Tuner
    from gmfbo.cli.tuning.study_display import StudyDisplay
    from gmfbo.interrupt import remembered_interrupt

    display = StudyDisplay(console, study.file.budget.is1_runs)
    with Tuner(study, resume=resume) as tuner, display, remembered_interrupt() as pressed:

        def show(step: Progress) -> None:
            if pressed.is_set():
                raise KeyboardInterrupt
            display.show(step)

        result = tuner.run(show)
    print_result(study, result)
    return result
