"""`gmfbo watch`: a running study, followed from its folder."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from gmfbo.cli.arguments import LivePage, StudyFolder
from gmfbo.cli.console import console
from gmfbo.cli.manual import Manual

if TYPE_CHECKING:
    from gmfbo.reports.study.follower import StudyFollower


MANUAL = Manual(
    examples={
        "Look every ten seconds:": "gmfbo watch joint.study --interval 10",
        "In a browser, from any machine that sees the folder:": (
            "gmfbo watch joint.study --html joint.html"
        ),
    },
    exits={130: "Ctrl-C; the study goes on"},
    see_also=("gmfbo tune", "gmfbo report", "notebooks/docs/reports.md"),
)


def watch(
    study: StudyFolder,
    interval: Annotated[
        float, typer.Option(min=0.1, metavar="SECONDS", help="Between two looks at the folder [s].")
    ] = 1.0,
    html: LivePage = None,
) -> None:
    """Follow a running study in the terminal until it ends.

    Ctrl-C stops watching, not the study. It reads the folder alone, so it may run on another
    machine that sees the folder.
    """
    from gmfbo.cli.tuning.live_study import LiveStudy
    from gmfbo.cli.tuning.watch_display import WatchDisplay
    from gmfbo.reports.study.follower import StudyFollower

    follower = StudyFollower(study)
    live = LiveStudy.begin(html)
    with live.following(study, owns=False), WatchDisplay(console, follower) as display:
        display.show(follower.news())
        live.show()
        while follower.state == "running":
            time.sleep(interval)
            display.show(follower.news())
            live.show()
    _print_end(follower)


def _print_end(follower: StudyFollower) -> None:
    from gmfbo.cli.tuning.study_result import print_result
    from gmfbo.reports.study.study_remarks import study_remarks, unmet_of_recommended
    from gmfbo.tuning.query.left_out import reasons_told
    from gmfbo.tuning.query.method import Recommendation
    from gmfbo.tuning.query.request import TuningResult

    review = follower.review
    if follower.state == "interrupted":
        console.print(
            f"interrupted after {len(review.runs)} runs; 'gmfbo tune STUDY.toml --resume' goes on",
            markup=False,
        )
    advised, taken = review.recommendation, review.logged("earlier")
    earlier = len(taken[-1]["trials"]) if taken else 0
    result = TuningResult(
        best=review.best,
        recommendation=Recommendation(advised["gains"], advised["mean"], advised["std"])
        if advised
        else None,
        is1_runs=len(review.real) - earlier,
        is2_runs=sum(run.trial.source == "IS2" for run in review.runs),
        is3_runs=sum(run.trial.source == "IS3" for run in review.runs),
        queries=review.runs[-1].query if review.runs else 0,
        cost=review.runs[-1].cost if review.runs else 0.0,
        drifts=review.drifts,
        twin_versions=tuple(one.reason for one in review.twin_versions),
        learned=review.twin_versions[-1].learned if review.twin_versions else (),
        earlier=earlier,
        left_out=taken[-1]["left_out"] if taken else 0,
        why_left_out=reasons_told(taken[-1].get("reasons", {}) if taken else {}),
        settled=review.settled,
        remarks=study_remarks(review),
        unmet=unmet_of_recommended(review),
    )
    print_result(review, result)
