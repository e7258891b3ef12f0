"""A study that still runs as a page that reloads itself, opened as a file without a server."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from html import escape
from typing import Literal

from gmfbo.pages.html_page import columns, page, page_file, paragraph, section
from gmfbo.pages.marked_number import scale_for
from gmfbo.plain_words import number, time_left, words
from gmfbo.reports.study.charts import error_chart, mismatch_chart, version_list
from gmfbo.reports.study.first_screen import responses_panel
from gmfbo.reports.study.gain_map import gain_map
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.study_remarks import (
    limits_missed,
    remarks_section,
    study_remarks,
)
from gmfbo.tuning.history.incumbent import none_settled
from gmfbo.tuning.study_file.study_sections import BudgetSection

State = Literal["running", "ended", "interrupted"]

RELOAD_S = 5
"""[s] Time after which a browser loads the page again: a real run takes seconds or more."""

_STATES: Mapping[State, tuple[str, str]] = {
    "running": ("running", "parameters"),
    "ended": ("ended", "none"),
    "interrupted": ("stopped", "missing_physics"),
}


def waiting_page(name: str) -> str:
    """Write the page of a study of which no run is done yet.

    Parameters
    ----------
    name : str
        Of the study.
    """
    told = "No run is done yet. The page fills as soon as there is one."
    body = (
        f'<header><div class="top"><span>Tuning of <b>{escape(name)}</b></span></div>'
        f'<h1 id="verdict">Waiting for the first run</h1>{paragraph(told, "lead")}</header>'
    )
    return _reloading(page(f"Tuning of {name}", body, styles=_styles(), scripts=()))


def live_page(review: StudyReview, state: State, seconds_left: float | None) -> str:
    """Write the page of a study as it stands.

    Parameters
    ----------
    review : StudyReview
        The study so far, with at least one run.
    state : {"running", "ended", "interrupted"}
        A page of a running study reloads itself; another one stays.
    seconds_left : float or None
        [s] Expected time until the end; None where it is not known.

    Returns
    -------
    str
        The whole page; it loads nothing and needs no script.
    """
    panel = responses_panel(review)
    # One value is no course: its chart would be empty.
    mismatch = mismatch_chart(review) if len(review.mismatch) > 1 else ""
    learned = columns(error_chart(review), mismatch) + version_list(review)
    if not learned:
        learned = paragraph("Nothing yet: no run has corrected the twin or measured its error.")
    layout = "first" if panel else "first alone"
    parts = [
        _head(review, state, seconds_left),
        f'<div class="{layout}">{panel}<div>{gain_map(review)}</div></div>',
        # While the study runs, what it lacks may still come.
        "" if state == "running" else remarks_section(study_remarks(review)),
        section("What was learned about the twin", _learned_words(review), learned),
        _footer(state),
    ]
    body = "\n".join(filter(None, parts))
    written = page(f"Tuning of {review.file.name}", body, styles=_styles(), scripts=())
    return _reloading(written) if state == "running" else written


def _styles() -> tuple[str, ...]:
    return page_file("style.css"), page_file("map.css"), page_file("study.css", __package__)


def _reloading(written: str) -> str:
    meta = f'<meta http-equiv="refresh" content="{RELOAD_S}">'
    return written.replace('<meta name="viewport"', f'{meta}<meta name="viewport"', 1)


def _head(review: StudyReview, state: State, seconds_left: float | None) -> str:
    file, best = review.file, review.best
    word, style = _STATES[state]
    if best is not None and not review.settled:
        word, style = f"{word}, none settled", "missing_physics"
    top = (
        f'<div class="top"><span>Tuning of <b>{escape(file.name)}</b></span>'
        f'<span class="badge {style}">{word}</span>'
        f"<span>method {escape(file.method)}, seed {file.seed}</span></div>"
    )
    if best is None:
        headline = "No real run has succeeded yet"
        if state == "ended":
            failed = len(review.real)
            headline = f"None of {failed} real runs succeeded, so there are no gains to take"
    else:
        gains = ", ".join(
            f'<span class="nowrap">{escape(name)} = {escape(_gain(review, name, value))}</span>'
            for name, value in best.gains.items()
        )
        headline = f"{_found(review, state)}: {gains}"
    return (
        f'<header>{top}<h1 id="verdict">{headline}</h1>{_progress(review, state, seconds_left)}'
        "</header>"
    )


def _found(review: StudyReview, state: State) -> str:
    """What the best gains are, which come next."""
    so_far = "" if state == "ended" else " so far"
    if review.settled:
        return f"Best gains{so_far}"
    told = "no real run has settled yet"
    if state == "ended":
        told = none_settled(len(review.real))
    return f"{told[0].upper()}{told[1:]}. Least bad{so_far}"


def _gain(review: StudyReview, name: str, value: float) -> str:
    unit = review.gain_unit(name)
    return f"{number(value, 4)} {unit}" if unit else number(value, 4)


def _progress(review: StudyReview, state: State, seconds_left: float | None) -> str:
    done, whole, what = done_of(review, review.file.budget)
    left = ""
    if state == "running":
        left = " The time left is not known yet."
        if seconds_left is not None:
            left = f" About {time_left(seconds_left)} left."
    elif state == "interrupted":
        left = " It was stopped; 'gmfbo tune --resume' goes on."
    simulated = len(review.runs) - len(review.real)
    told = f"{done} of {whole} {what} done.{left} So far {len(review.real)} real runs, {simulated} "
    bar = f'<progress max="{whole}" value="{min(done, whole)}">{done} of {whole}</progress>'
    return bar + paragraph(f"{told}simulated. {limits_missed(review)}".rstrip(), "lead")


def done_of(review: StudyReview, budget: BudgetSection) -> tuple[int, int, str]:
    """Count what ends the study: number done, number at its end, and its name.

    Parameters
    ----------
    review : StudyReview
        The study so far.
    budget : BudgetSection
        Of its file.
    """
    if budget.is1_runs is None:
        return review.runs[-1].query, budget.most_queries, "queries"
    made = sum(run.role != "earlier" for run in review.real)
    return made, budget.is1_runs, "real runs"


def _learned_words(review: StudyReview) -> str:
    if not review.correction:
        return ""
    _, before, after = review.correction[-1]
    if not 0.0 <= after < before:
        return paragraph("At the newest real run, correcting the twin did not lower its error.")
    signal = review.file.objective.signal
    unit = review.signal_unit(signal)
    scale = scale_for(before, unit)
    old, new = (number(error / scale.factor) for error in (before, after))
    return paragraph(
        f"At the newest real run, correcting the twin by the runs so far lowers its error of "
        f"{words(signal)} from {old} to {new} {escape(scale.unit)}."
    )


def _footer(state: State) -> str:
    now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    again = (
        f" This page reloads every {RELOAD_S} s; an old time here means that nothing writes it "
        "any more."
        if state == "running"
        else " 'gmfbo report' writes the page with every run."
    )
    return f"<footer>{paragraph(f'Written {now}.{again}')}</footer>"
