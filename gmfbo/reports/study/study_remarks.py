"""What has to be said of a study beside its best gains, in the words of the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from gmfbo.pages.html_page import section
from gmfbo.reports.study.review import StudyReview
from gmfbo.tuning.history.remarks import (
    ended_early,
    remarks_on,
    unmet_limits,
    worth_remarks,
)


def study_remarks(review: StudyReview) -> tuple[str, ...]:
    """What the best gains alone do not tell.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    """
    real = [run.trial for run in review.real]
    made = sum(run.role != "earlier" for run in review.real)
    queries = review.runs[-1].query if review.runs else 0
    return (
        *remarks_on(review.file, real, review.best, review.box, review.metric_words),
        *ended_early(review.file.budget, queries, made),
        *worth_remarks(review.events),
    )


def remarks_section(remarks: Sequence[str]) -> str:
    """Write the remarks as a section of the page; nothing for none.

    Parameters
    ----------
    remarks : sequence of str
        Of `study_remarks`.
    """
    told = "".join(f"<li>{escape(remark)}</li>" for remark in remarks)
    return section("Remarks", f"<ul>{told}</ul>" if told else "", name="remarks")


def unmet_of_recommended(review: StudyReview) -> tuple[str, ...]:
    """Limits that the recommended gains do not meet; empty where nothing is recommended.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    """
    advised = review.recommendation
    if advised is None:
        return ()
    real = [run.trial for run in review.real]
    return unmet_limits(advised["gains"], real, review.limits, review.metric_words)


def limits_missed(review: StudyReview) -> str:
    """Sentence that the best real run does not meet the limits; empty where it does.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    """
    best, limits = review.best, review.limits
    if best is None or limits.met(best.metrics):
        return ""
    finished = [run.trial for run in review.real if run.trial.status == "ok"]
    told = f"The {review.best_words} run does not meet the limits"
    any_does = any(limits.met(trial.metrics) for trial in finished)
    return f"{told}." if any_does else f"{told}; no real run does."
