"""A tuning study as one page that needs no network."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from gmfbo.pages.html_page import columns, page, page_file, paragraph, section
from gmfbo.pages.marked_number import marked_count
from gmfbo.pages.svg_axis import Axis
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.reports.study.charts import descent_charts, source_chart, trust_charts, version_list
from gmfbo.reports.study.first_screen import objective_words, study_first_screen
from gmfbo.reports.study.gain_map import gain_map
from gmfbo.reports.study.page_json import study_content, study_json
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.runs_table import runs_tables
from gmfbo.reports.study.study_remarks import remarks_section
from gmfbo.reports.study.trade_offs import trade_offs
from gmfbo.reports.study.trajectory_json import trajectories_json


def study_page(review: StudyReview) -> str:
    """Write the page of a study.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.

    Returns
    -------
    str
        HTML with its style, drawings and numbers in it; every text of the study is escaped,
        every number in a table marked with its place in the JSON that the page holds.
    """
    content = study_content(review)
    parts = [
        study_first_screen(review, content),
        remarks_section(content["remarks"]),
        section("Gains that were run", columns(gain_map(review), _viewer()), name="runs"),
        section("On the way to the best", descent_charts(review), objective_words(review)),
        section("What one metric costs the other", trade_offs(review), name="trade-off"),
        section("Who was asked", source_chart(review)),
        section("How far the twin was trusted", trust_charts(review), name="trust"),
        section("What changed on the way", version_list(review), name="changes"),
        section("The runs in numbers", runs_tables(review)),
        _footer(content),
        study_json(content),
        trajectories_json(review),
    ]
    return page(
        f"Tuning of {review.file.name}",
        "\n".join(filter(None, parts)),
        styles=(page_file("style.css"), page_file("map.css"), page_file("study.css", __package__)),
        scripts=(page_file("charts.js"), page_file("study.js", __package__)),
    )


def _viewer() -> str:
    empty = framed(
        Axis(0.0, 1.0, 0.0, WIDE),
        Axis(0.0, 1.0, HIGH, 0.0),
        [],
        title="trajectories of the chosen run",
        x_label="time [s]",
        y_label="signal",
    )
    return (
        '<figure class="panel" id="viewer" hidden><figcaption id="told" role="status">'
        f'</figcaption><ul class="legend"></ul>{empty}</figure>'
        "<noscript><p>The trajectories of each run are inside this file; choosing one needs "
        "JavaScript.</p></noscript>"
    )


def _footer(content: Mapping[str, Any]) -> str:
    first, last = content["runs"][0], content["runs"][-1]
    begin, end = (run["started"].replace("T", " ")[:19] for run in (first, last))
    when = escape(f"Runs from {begin} to {end} UTC. ")
    queries = marked_count(("queries",), content["queries"])
    return (
        f"<footer><p>{when}{queries} queries after the initial data.</p>"
        + paragraph(
            "All numbers on this page are those of the study's HDF5 store, and are also inside "
            "this file.",
            "soft",
        )
        + "</footer>"
    )
