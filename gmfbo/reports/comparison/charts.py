"""Charts of a comparison: means with their intervals, every seed, and the true landscape."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from gmfbo.pages.html_page import columns, paragraph
from gmfbo.pages.shaded_map import shade_levels, shaded_cells
from gmfbo.pages.svg_axis import Array, Axis, CountAxis, LogAxis
from gmfbo.pages.svg_chart import Band, Line, band_path, line_path, swatch
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.reports.comparison.curves import ComparisonReview, Curve

ARRIVED = 0.02
"""Regret at which a method counts as arrived."""

LEAST_REGRET = 1e-3
"""Smaller regrets do not differ significantly, and zero cannot be drawn."""

_REAL_RUNS = "real runs, initial ones counted"
_STYLES = 12  # of methods, in the page's style


def _method_style(review: ComparisonReview, method: str) -> str:
    return f"m{_methods(review).index(method) % _STYLES}"


def method_buttons(review: ComparisonReview) -> str:
    """Legend of all charts; with the page's script, a click hides or shows a method."""
    buttons = "".join(
        f'<button type="button" aria-pressed="true" data-method="{escape(name)}" '
        f'data-style="{_method_style(review, name)}">{swatch(_method_style(review, name))}'
        f"{escape(name)}</button>"
        for name in _methods(review)
    )
    return f'<div class="switch methods" role="group" aria-label="methods shown">{buttons}</div>'


def regret_chart(review: ComparisonReview) -> str:
    """Draw the simple regret against real runs."""
    curves = _of(review, "regret")
    values = [np.maximum(ends, LEAST_REGRET) for c in curves for ends in (c.mean, c.low, c.high)]
    y_axis = LogAxis.over([*values, np.array([ARRIVED])], HIGH, 0.0, margin=0.04)
    note = "Mean over seeds with its 95 % interval. Dashed: where a method counts as arrived."
    return _curves(
        review,
        curves,
        y_axis,
        title="what is left of the way to the optimum against real runs",
        x_label=_REAL_RUNS,
        y_label="left of the way from the optimum to the median gains [1]",
        inside=[_level(ARRIVED, y_axis)],
        note=note,
    )


def objective_chart(review: ComparisonReview) -> str:
    """Draw the best objective so far against real runs."""
    curves = _of(review, "objective")
    return _curves(
        review,
        curves,
        _spanning(curves),
        title="best objective so far against real runs",
        x_label=_REAL_RUNS,
        y_label="best observed objective g [1], lower is better",
    )


def cost_chart(review: ComparisonReview) -> str:
    """Draw the cost of all runs against queries."""
    curves = _of(review, "cost")
    return _curves(
        review,
        curves,
        _spanning(curves, np.zeros(1)),
        title="cost of all runs against queries",
        x_label="queries after the initial data",
        y_label="cost of all runs [real runs]",
        along="query",
        note="A real run costs 1, a run of the twin 0.1, corrected or not.",
    )


def seed_charts(review: ComparisonReview) -> list[str]:
    """Draw every seed of each method, and their mean."""
    if not review.runs:
        return []
    means = {curve.method: curve for curve in _of(review, "regret")}
    whole = np.concatenate([np.maximum(run.regret, LEAST_REGRET) for run in review.runs])
    x_end = float(max(run.regret.size for run in review.runs))
    y_axis = LogAxis.over([whole, np.array([ARRIVED])], HIGH, 0.0, margin=0.04)
    x_axis = CountAxis.over([np.array([1.0, x_end])], 0.0, WIDE, 0.3)
    charts = []
    for method in _methods(review):
        own = [run for run in review.runs if run.method == method]
        style = _method_style(review, method)
        lines = [
            Line(
                f"seed {run.seed}",
                f"{style} thin",
                np.arange(1.0, run.regret.size + 1.0),
                run.regret,
            )
            for run in own
        ]
        mean = means.get(method)
        if mean is not None:
            lines.append(Line("mean", style, mean.x, mean.mean))
        chart = framed(
            x_axis,
            y_axis,
            [_level(ARRIVED, y_axis), *(line_path(line, x_axis, y_axis) for line in lines)],
            title=f"{method}: what is left of the way to the optimum, each seed",
            x_label=_REAL_RUNS,
            y_label="left of the way [1]",
            style="middle",
        )
        caption = f"<figcaption><b>{escape(method)}</b>, {len(own)} seeds</figcaption>"
        charts.append(f'<figure data-method="{escape(method)}">{caption}{chart}</figure>')
    return charts


def landscape_maps(review: ComparisonReview) -> str:
    """Draw the true objective over two gains, and the relative error of the twin."""
    found = review.landscape
    if found is None:
        return ""
    x_axis = Axis(float(found.x[0]), float(found.x[-1]), 0.0, WIDE)
    y_axis = Axis(float(found.y[0]), float(found.y[-1]), HIGH, 0.0)
    row, column = np.unravel_index(int(np.argmin(found.objective)), found.objective.shape)
    across = 100.0 * float(x_axis.at(float(found.x[row]))) / WIDE
    down = 100.0 * float(y_axis.at(float(found.y[column]))) / HIGH
    star = f'<text class="optimum" x="{across:.2f}%" y="{down:.2f}%" dy="7">★</text>'
    maps = [
        _map(values, title, (x_axis, y_axis), found.names, star)
        for values, title in (
            (found.objective, "true objective g of the plant [1]"),
            (found.error, "relative error of the twin's cost G [%]"),
        )
    ]
    note = (
        f"Of seed {found.seed}. Star: the best gains of the plant. Shades by rank, as much area of "
        "each: strong is low."
    )
    return columns(*maps) + paragraph(note, "soft small")


def _map(
    values: Array, title: str, axes: tuple[Axis, Axis], names: tuple[str, str], star: str
) -> str:
    levels = shade_levels(values)
    least, median, largest = np.quantile(values, [0.0, 0.5, 1.0])
    ends = f"Least {least:.3g}, median {median:.3g}, largest {largest:.3g}."
    chart = framed(
        *axes,
        [],
        title=f"{title} over {names[0]} and {names[1]}",
        x_label=names[0],
        y_label=names[1],
        style="map",
        under=shaded_cells(values, levels),
        over=[star],
    )
    caption = f"<figcaption><b>{escape(title)}</b></figcaption>"
    return f"<figure>{caption}{chart}{paragraph(ends, 'soft small')}</figure>"


def _curves(
    review: ComparisonReview,
    curves: Sequence[Curve],
    y_axis: Axis,
    *,
    title: str,
    x_label: str,
    y_label: str,
    along: str = "real run",
    inside: Sequence[str] = (),
    note: str = "",
) -> str:
    x_axis = CountAxis.over([curve.x for curve in curves], 0.0, WIDE, 0.3)
    drawn = list(inside)
    for curve in curves:
        style = _method_style(review, curve.method)
        drawn.append(band_path(Band(curve.x, curve.low, curve.high, style), x_axis, y_axis))
    for curve in curves:
        line = Line(curve.method, _method_style(review, curve.method), curve.x, curve.mean)
        drawn.append(line_path(line, x_axis, y_axis))
    chart = framed(x_axis, y_axis, drawn, title=title, x_label=x_label, y_label=y_label)
    told = paragraph(note, "soft small")
    return (
        f'<figure data-curve="{escape(curves[0].name)}" data-along="{escape(along)}" tabindex="0" '
        f'aria-label="{escape(title)}; left and right arrow keys read the values">{chart}{told}'
        "</figure>"
        if curves
        else ""
    )


def _level(value: float, y_axis: Axis) -> str:
    return f'<path class="line floor" d="M0 {float(y_axis.at(value)):.0f}H{WIDE:g}"/>'


def _spanning(curves: Sequence[Curve], *more: Array) -> Axis:
    ends = [column for curve in curves for column in (curve.low, curve.high)]
    return Axis.over([*ends, *more], HIGH, 0.0, margin=0.04)


def _of(review: ComparisonReview, name: str) -> list[Curve]:
    return [curve for curve in review.curves if curve.name == name]


def _methods(review: ComparisonReview) -> list[str]:
    return list(dict.fromkeys(curve.method for curve in review.curves))
