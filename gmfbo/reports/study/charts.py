"""Charts of a study: best run so far, queried sources, and trust in the twin."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.mismatch import query_cost, source_lengthscale
from gmfbo.pages.html_page import columns, paragraph
from gmfbo.pages.marked_number import unit_text
from gmfbo.pages.svg_axis import Axis, CountAxis, LogAxis, NamedAxis
from gmfbo.pages.svg_chart import Line, legend, line_path
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.plain_words import words
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_marks import SOURCES, best_mark, run_mark

Array = NDArray[np.float64]

_MOST_COUNTS = 40  # queries whose counts can be read side by side


def descent_charts(review: StudyReview) -> str:
    """Draw the best real run so far, against real runs and against the cost of all runs."""
    descent = review.descent
    if not descent.numbers:
        return ""
    count = np.arange(1.0, len(descent.numbers) + 1.0)
    told = legend([Line(f"{review.best_words} so far", "after", count, count)])
    charts = [
        _descent(review, count, CountAxis.over([count], 0.0, WIDE, 0.5), "real runs"),
        _descent(
            review,
            descent.cost,
            Axis.over([descent.cost, np.zeros(1)], 0.0, WIDE, 0.03),
            "cost of all runs so far [real runs]",
        ),
    ]
    rule = paragraph(
        "Circles are the real runs; a dashed one ended early and is no best. A real run costs 1, a "
        "run of the twin 0.1, corrected or not.",
        "soft small",
    )
    return columns(*(f"<figure>{told}{chart}</figure>" for chart in charts)) + rule


def _descent(review: StudyReview, x: Array, x_axis: Axis, x_label: str) -> str:
    descent = review.descent
    y_axis = Axis.over([descent.objective, descent.best], HIGH, 0.0, margin=0.08)
    marks = []
    for run, at, height in zip(review.real, x, descent.objective, strict=True):
        draw = best_mark if run.trial is review.best else run_mark
        marks.append(draw(run, float(at), float(height), x_axis, y_axis))
    # A best holds until the next real run is done.
    steps = Line("", "after", np.repeat(x, 2)[1:], np.repeat(descent.best, 2)[:-1])
    return framed(
        x_axis,
        y_axis,
        [line_path(steps, x_axis, y_axis)],
        title=f"best objective so far against {x_label}",
        x_label=x_label,
        y_label="objective g [1], lower is better",
        over=marks,
    )


def source_chart(review: StudyReview) -> str:
    """Draw the source of each query, and the number of runs of each source that it caused."""
    last = review.runs[-1].query
    x_axis = _query_axis(review)
    shown = [source for source in SOURCES if review.of(source)]
    y_axis = NamedAxis.of([*shown[::-1]], HIGH, 0.0)
    over = []
    for row, source in enumerate(shown[::-1]):
        for query in range(last + 1):
            here = [run for run in review.of(source) if run.query == query]
            if here:
                asked = [run for run in here if run.role == "query"]
                chosen = (asked or here)[0]
                style = "asked" if asked else "came-along"
                over.append(run_mark(chosen, query, row, x_axis, y_axis, style))
                if last <= _MOST_COUNTS and len(here) > 1:
                    over.append(_count(len(here), query, row, x_axis, y_axis))
    told = paragraph(
        "At 0 the initial data. Filled: the source that the method asked. Hollow: runs that came "
        "with it: the twin beside a real run, and the corrected ones around it. Numbers: how "
        "many.",
        "soft small",
    )
    chart = framed(
        x_axis,
        y_axis,
        _new_twins(review, x_axis),
        title="source that was asked at each query",
        x_label="query of the method",
        y_label="source",
        style="low sources",
        over=over,
    )
    return f"<figure>{chart}</figure>{told}"


def _count(count: int, x: float, y: float, x_axis: Axis, y_axis: Axis) -> str:
    across = 100.0 * float(x_axis.at(x)) / WIDE
    down = 100.0 * float(y_axis.at(y)) / HIGH
    return f'<text class="count" x="{across:.2f}%" y="{down:.2f}%" dy="-10">{count}</text>'


def trust_charts(review: StudyReview) -> str:
    """Draw mismatch, lengthscale, query cost, and the twin's error before and after correction."""
    charts = [mismatch_chart(review), _allowed_chart(review), error_chart(review)]
    return columns(*charts, style="three")


def mismatch_chart(review: StudyReview) -> str:
    """Draw the mismatch of the twin over the queries; nothing where no method asked for it."""
    queries, values = mismatch_series(review)
    if not queries.size:
        return ""
    lines = [Line("mismatch e of the twin", "before dots", queries, values)]
    return _over_queries(
        review, lines, "mismatch e [1]", "mismatch of the twin over the queries"
    ) + (paragraph("By what share correcting the twin's runs changes their cost.", "soft small"))


def _allowed_chart(review: StudyReview) -> str:
    queries, values = mismatch_series(review)
    if not queries.size:
        return ""
    lengths = np.array([source_lengthscale(value) for value in values])
    prices = np.array([query_cost(value) for value in values])
    lines = [
        Line("trust: lengthscale between the sources", "after dots", queries, lengths),
        Line("price of a query of the twin", "spline dots", queries, prices),
    ]
    return _over_queries(
        review, lines, "trust and price [1]", "trust in the twin over the queries"
    ) + (
        paragraph(
            "What this mismatch allows by the rule of Nobar et al. 2025: 1/e and e, each within "
            "0.1 and 1. Methods that adapt act on it, each in its own way.",
            "soft small",
        )
    )


def error_chart(review: StudyReview) -> str:
    """Draw the twin's error before and after correction; nothing where none was made."""
    x, twin, corrected = error_series(review)
    if not x.size:
        return ""
    signal = review.file.objective.signal
    unit = unit_text(review.signal_unit(signal)) or "1"
    lines = [
        Line("twin", "before dots", x, twin),
        Line("corrected twin, held out", "after dots", x, corrected),
    ]
    return _over_queries(
        review,
        lines,
        f"RMS error of {words(signal)} [{unit}]",
        "error of the twin before and after correction over the queries",
        y_axis=LogAxis.over([twin, corrected], HIGH, 0.0, margin=0.08),
    ) + paragraph(
        "Beside each real run: each sample predicted from the others. What is left of the twin's "
        "error near the runs that were made, not far from them.",
        "soft small",
    )


def mismatch_series(review: StudyReview) -> tuple[Array, Array]:
    """Queries with a mismatch, and the mismatch e.

    Returns
    -------
    query, mismatch : ndarray, shape (n,)
        Both dimensionless.
    """
    queries = {run.trial.number: run.query for run in review.runs}
    told = [(float(queries[number]), value) for number, value in review.mismatch]
    query, mismatch = np.reshape(np.array(told, dtype=float), (-1, 2)).T
    return query, mismatch


def error_series(review: StudyReview) -> tuple[Array, Array, Array]:
    """Queries with a correction, and the RMS error of the twin before and after it.

    Returns
    -------
    query, twin, corrected : ndarray, shape (n,)
        Errors [unit of the scored signal]; the corrected twin predicts each sample from the
        others.
    """
    queries = {run.trial.number: run.query for run in review.runs}
    told = [(float(queries[number]), *errors) for number, *errors in review.correction]
    query, twin, corrected = np.reshape(np.array(told, dtype=float), (-1, 3)).T
    return query, twin, corrected


def _over_queries(
    review: StudyReview,
    lines: Sequence[Line],
    y_label: str,
    title: str,
    y_axis: Axis | None = None,
) -> str:
    x_axis = _query_axis(review)
    y_axis = y_axis or Axis.over([np.zeros(1), *(line.y for line in lines)], HIGH, 0.0, 0.05)
    chart = framed(
        x_axis,
        y_axis,
        [*_new_twins(review, x_axis), *(line_path(line, x_axis, y_axis) for line in lines)],
        title=title,
        x_label="query of the method",
        y_label=y_label,
        style="middle",
    )
    return f"<figure>{legend(lines)}{chart}</figure>"


def _query_axis(review: StudyReview) -> CountAxis:
    return CountAxis.over([np.array([0.0, float(review.runs[-1].query)])], 0.0, WIDE, 0.5)


def _new_twins(review: StudyReview, x_axis: Axis) -> list[str]:
    """Lines across the chart where a twin replaced another, between two queries."""
    drawn = []
    for one in review.twin_versions:
        before = [run.query for run in review.runs if run.trial.number <= one.after]
        at = float(x_axis.at(max(before, default=0) + 0.5))
        drawn.append(f'<path class="new-twin" d="M{at:.0f} 0V{HIGH:g}"/>')
    return drawn


def _lines(learned: Sequence[str]) -> str:
    entries = "".join(f"<li>{escape(line)}</li>" for line in learned)
    return f"<ul>{entries}</ul>" if entries else ""


def version_list(review: StudyReview) -> str:
    """List the twins that replaced another, and the changes of the plant, with reasons."""
    entries = [
        f"<li><b>Twin {escape(one.version)}</b>, after run {one.after} (dotted line in the charts "
        f"above): {escape(one.reason)}{_lines(one.learned)}</li>"
        for one in review.twin_versions
    ]
    entries += [f"<li><b>Plant</b>: {escape(one.message)}</li>" for one in review.drifts]
    return f'<ul class="key">{"".join(entries)}</ul>' if entries else ""
