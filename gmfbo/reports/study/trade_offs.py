"""Trade-offs: the real runs over any two metrics, those that none beats marked."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.margins import AT_LEAST
from gmfbo.pages.html_page import paragraph
from gmfbo.pages.svg_axis import Axis
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.reports.study.metric_cells import metric_head
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_marks import run_mark
from gmfbo.reports.study.run_roles import Run


def unbeaten(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Runs that none beats: no other is at least as good in all metrics and better in one.

    Parameters
    ----------
    values : ndarray, shape (n, k)
        Metrics of n runs; less is better.

    Returns
    -------
    ndarray of bool, shape (n,)
        The Pareto set.
    """
    no_worse = np.all(values[:, None, :] <= values[None, :, :], axis=2)
    better = np.any(values[:, None, :] < values[None, :, :], axis=2)
    return np.asarray(~np.any(no_worse & better, axis=0))


def trade_offs(review: StudyReview) -> str:
    """Draw the real runs that succeeded over each pair of metrics; a script shows one of them.

    A run that never reached a time has none to draw, and is left out of that time's figures.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.

    Returns
    -------
    str
        HTML; empty with fewer than two runs or two metrics that differ among them.
    """
    runs = [run for run in review.real if run.trial.status == "ok"]
    names = [name for name in review.metrics if "[" not in name and _tells(runs, name)]
    if len(names) < 2:
        return ""
    drawn = [(pair, _reached(review, runs, pair)) for pair in combinations(names, 2)]
    told = [all(_tells(left, name) for name in pair) for pair, left in drawn]
    if not any(told):
        return ""
    figures = [
        _figure(review, left, pair, shown=place == told.index(True))
        if told[place]
        else _no_figure(pair)
        for place, (pair, left) in enumerate(drawn)
    ]
    without = any(len(left) < len(runs) for _, left in drawn)
    rule = paragraph(
        "Filled: runs that none beats, since no other is at least as good in both metrics and "
        "better in one. Circles of failed runs are left out"
        + (", and those of runs that never reached one of both times." if without else "."),
        "soft small",
    )
    return f'<div id="trade-offs">{"".join(figures)}</div>{rule}'


def _reached(review: StudyReview, runs: Sequence[Run], pair: tuple[str, str]) -> list[Run]:
    """Runs that reached both times, where a metric is one."""
    never = review.metric_words.is_never
    return [run for run in runs if not any(never(n, run.trial.metrics[n]) for n in pair)]


def _tells(runs: Sequence[Run], name: str) -> bool:
    """Whether a metric is known for all of these runs and differs among them."""
    values = np.array([run.trial.metrics.get(name, np.nan) for run in runs])
    return bool(len(runs) > 1 and np.isfinite(values).all() and np.ptp(values) > 0.0)


def _figure(review: StudyReview, runs: Sequence[Run], pair: tuple[str, str], *, shown: bool) -> str:
    across, up = (np.array([run.trial.metrics[name] for run in runs]) for name in pair)
    signs = [-1.0 if name in AT_LEAST else 1.0 for name in pair]
    kept = unbeaten(np.column_stack([across, up]) * signs)
    x_axis = Axis.over([across], 0.0, WIDE, 0.06)
    y_axis = Axis.over([up], HIGH, 0.0, margin=0.08)
    marks = [
        run_mark(run, float(x), float(y), x_axis, y_axis, "unbeaten" if best else "beaten")
        for run, x, y, best in zip(runs, across, up, kept, strict=True)
    ]
    x_label, y_label = (_label(review, name) for name in pair)
    chart = framed(
        x_axis,
        y_axis,
        [],
        title=f"{x_label} against {y_label} of the real runs",
        x_label=x_label,
        y_label=y_label,
        over=marks,
    )
    return _framed(pair, chart, shown=shown)


def _no_figure(pair: tuple[str, str]) -> str:
    """What stands in place of a figure that fewer than two different runs are left for."""
    return _framed(pair, paragraph("Too few runs reached both times.", "soft"), shown=False)


def _framed(pair: tuple[str, str], content: str, *, shown: bool) -> str:
    hidden = "" if shown else " hidden"
    one, other = (escape(name) for name in pair)
    return f'<figure data-x="{one}" data-y="{other}"{hidden}>{content}</figure>'


def _label(review: StudyReview, name: str) -> str:
    better = ", more is better" if name in AT_LEAST else ""
    return metric_head(review, name) + better
