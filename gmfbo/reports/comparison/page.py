"""A comparison of methods as one page that needs no network."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from typing import Any

from gmfbo.pages.html_page import (
    columns,
    embedded_json,
    folded,
    page,
    page_file,
    paragraph,
    section,
    table,
)
from gmfbo.pages.marked_number import Path, marked_count, marked_number, marked_percent
from gmfbo.reports.comparison.charts import (
    cost_chart,
    landscape_maps,
    method_buttons,
    objective_chart,
    regret_chart,
    seed_charts,
)
from gmfbo.reports.comparison.curves import ComparisonReview, MethodSummary, Spread

_ARRIVED = (
    "n* counts real runs, initial ones included, until the best is within 2 % of the way from the "
    "true optimum to the median gains"
)


def comparison_page(review: ComparisonReview) -> str:
    """Write the page of a comparison.

    Parameters
    ----------
    review : ComparisonReview
        Read from a comparison's folder.

    Returns
    -------
    str
        HTML with its style, drawings and numbers in it; every number in a table is marked with
        its place in the JSON that the page holds.
    """
    content = _content(review)
    summary = _summary_table(review)
    layout = "first" if summary else "first alone"
    parts = [
        _head(review),
        method_buttons(review),
        f'<div class="{layout}">{regret_chart(review)}{summary}</div>',
        section("On the way", columns(objective_chart(review), cost_chart(review))),
        section("Every seed", columns(*seed_charts(review), style="three"), _seeds(review)),
        section("What there was to find", landscape_maps(review)),
        section(
            "All tables",
            folded("As gmfbo compare prints them", f"<pre>{escape(review.text)}</pre>"),
        ),
        _footer(),
        embedded_json("comparison", json.dumps(content, separators=(",", ":"), allow_nan=False)),
    ]
    return page(
        f"Comparison {review.name}",
        "\n".join(filter(None, parts)),
        styles=(
            page_file("style.css"),
            page_file("map.css"),
            page_file("comparison.css", __package__),
        ),
        scripts=(page_file("charts.js"), page_file("comparison.js", __package__)),
    )


def _head(review: ComparisonReview) -> str:
    top = f'<div class="top"><span>Comparison <b>{escape(review.name)}</b></span></div>'
    if not review.methods:
        return (
            f'<header>{top}<h1 id="verdict">Methods on the same seeds</h1>'
            f"{paragraph('Its runs were not kept, only its tables and curves.', 'lead')}</header>"
        )
    never = review.runs[0].never
    return (
        f'<header>{top}<h1 id="verdict">{_headline(review)}</h1>'
        f'<p class="lead">{_ARRIVED}; {never} stands for never.</p></header>'
    )


def _headline(review: ComparisonReview) -> str:
    order = sorted(range(len(review.methods)), key=lambda k: review.methods[k].mean.value)
    best = review.methods[order[0]]
    if best.never == 1.0:
        return "No method reached the optimum on any seed"
    told = f"{escape(best.method)} needs the fewest real runs: {_mean(order[0], best)} on average"
    if len(order) > 1:
        second = review.methods[order[1]]
        told += f", {escape(second.method)} {_mean(order[1], second)}"
        if second.mean.value == best.mean.value:
            return told.replace(" needs the fewest", " is among those with the fewest", 1)
        if second.mean.low <= best.mean.high:
            told += " (the intervals overlap)"
    return told


def _mean(place: int, one: MethodSummary) -> str:
    return _interval(("methods", place, "mean"), one.mean)


def _interval(path: Path, spread: Spread) -> str:
    value, low, high = (
        marked_number((*path, name), getattr(spread, name)) for name in ("value", "low", "high")
    )
    return f'<span class="nowrap">{value} [{low}, {high}]</span>'


def _summary_table(review: ComparisonReview) -> str:
    rows = [
        [
            escape(one.method),
            _interval(("methods", k, "mean"), one.mean),
            marked_number(("methods", k, "median", "value"), one.median.value),
            marked_percent(("methods", k, "never"), one.never),
            marked_percent(("methods", k, "regret"), one.regret),
            marked_number(("methods", k, "cost"), one.cost),
        ]
        for k, one in enumerate(review.methods)
    ]
    heads = ("method", "n*, mean [95 %]", "median", "never", "left at the end", "cost")
    best = min(range(len(rows)), key=lambda k: review.methods[k].mean.value, default=None)
    told = table(heads, rows, numbers=range(1, len(heads)), style="wide errors", best=best)
    note = (
        "Means over seeds. Left at the end: of the way from the optimum to the median gains. Cost: "
        "of all runs, in real runs."
    )
    return f'<div class="numbers">{told}{paragraph(note, "soft small")}</div>' if told else ""


def _seed_table(review: ComparisonReview) -> str:
    if not review.runs:
        return ""
    methods = [one.method for one in review.methods]
    places = {(run.method, run.seed): k for k, run in enumerate(review.runs)}
    seeds = sorted({run.seed for run in review.runs})
    rows = [
        [
            _seed_cell(seed, [places.get((method, seed)) for method in methods]),
            *(_arrival(review, places.get((method, seed))) for method in methods),
        ]
        for seed in seeds
    ]
    told = paragraph("n* of every seed; a dash where the method never arrived.", "soft small")
    return told + table(["seed", *methods], rows, numbers=range(1, len(methods) + 1), style="seeds")


def _seeds(review: ComparisonReview) -> str:
    return columns(_seed_table(review), _effort_table(review))


def _effort_table(review: ComparisonReview) -> str:
    rows = [
        [
            escape(one.method),
            marked_count(("methods", k, "seeds"), one.seeds),
            _interval(("methods", k, "median"), one.median),
            marked_number(("methods", k, "seconds"), one.seconds),
        ]
        for k, one in enumerate(review.methods)
    ]
    heads = ("method", "seeds", "n*, median [95 %]", "time of a study, mean [s]")
    return table(heads, rows, numbers=(1, 2, 3))


def _seed_cell(seed: int, places: Sequence[int | None]) -> str:
    first = next(place for place in places if place is not None)
    return marked_count(("runs", first, "seed"), seed)


def _arrival(review: ComparisonReview, place: int | None) -> str:
    if place is None:
        return ""
    found = review.runs[place].n_star
    return marked_number(("runs", place, "n_star"), float("nan") if found is None else found)


def _footer() -> str:
    told = "All numbers on this page are those of the comparison's folder, and are also inside "
    return f"<footer>{paragraph(told + 'this file.', 'soft')}</footer>"


def _content(review: ComparisonReview) -> dict[str, Any]:
    """Tell a comparison in numbers and names."""
    return {
        "schema": 1,
        "name": review.name,
        "methods": [asdict(one) for one in review.methods],
        "runs": [
            {**asdict(run), "best": run.best.tolist(), "regret": run.regret.tolist()}
            for run in review.runs
        ],
        "curves": [
            {
                "method": curve.method,
                "name": curve.name,
                "seeds": curve.seeds,
                **{key: getattr(curve, key).tolist() for key in ("x", "mean", "low", "high")},
            }
            for curve in review.curves
        ],
    }
