"""Figures of a study, for a notebook or a paper; they need matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gmfbo.errors import InputError
from gmfbo.objective.mismatch import query_cost, source_lengthscale
from gmfbo.plain_words import words
from gmfbo.reports.figures.figure_map import draw_map
from gmfbo.reports.figures.figure_style import (
    BLUE,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    axis_label,
    count_along,
    gain_label,
    in_style,
    new_figure,
    save_figure,
)
from gmfbo.reports.figures.trajectory_figure import trajectories
from gmfbo.reports.study.charts import error_series, mismatch_series
from gmfbo.reports.study.gain_map import cost_map
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_marks import SOURCES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OBJECTIVE = "objective g [1]"
_QUERIES = "query of the method [1]"
_MARKS = {"IS2": ("s", VERMILION, 3.0), "IS3": ("^", PURPLE, 4.0), "IS1": ("o", BLUE, 6.0)}
"""Shape, colour and size of each source's runs; shapes alone differ too."""


def draw_study(review: StudyReview, folder: Path) -> list[Path]:
    """Draw all figures that a study has data for, each as PDF and SVG.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    folder : Path
        Made where it is missing.

    Returns
    -------
    list of Path
        All files.

    Raises
    ------
    InputError
        matplotlib is missing, or a file cannot be written.
    """
    figures = {"sampling_cost": sampling_cost(review)}
    if len(review.space):
        figures["gains"] = gains(review)
    if review.real:
        figures["best_observed"] = best_observed(review)
    if any(not run.trial.bare for run in review.real):
        figures["trajectories"] = trajectories(review)
    if review.mismatch or review.correction:
        figures["mismatch_and_trust"] = mismatch_and_trust(review)
    return [
        save_figure(figure, folder / f"{name}{ending}")
        for name, figure in figures.items()
        for ending in (".pdf", ".svg")
    ]


@in_style
def gains(review: StudyReview) -> Figure:
    """Draw the gains of all runs: two over a map of the twin's cost, else each against cost.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.

    Returns
    -------
    matplotlib.figure.Figure
        One map, or a panel for each gain.

    Raises
    ------
    InputError
        No gain was moved yet; or matplotlib is missing.
    """
    names = review.space.names
    if not names:
        raise InputError("expected a study that has moved a gain, got none; wait for more runs")
    if len(names) == 2:
        return _gain_map(review)
    figure = new_figure(3.4 * len(names) + 1.0, 3.4)
    panels = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axes, name in zip(panels, names, strict=True):
        for source, (shape, colour, size) in _MARKS.items():
            own = [run.trial for run in review.of(source)]
            _points(axes, [t.gains[name] for t in own], [t.objective for t in own],
                    (shape, colour, size), SOURCES[source])  # fmt: skip
        axes.set_xlabel(gain_label(name, review.gain_unit(name)), parse_math=False)
    panels[0].set_ylabel(_OBJECTIVE)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper", frameon=False)
    return figure


def _gain_map(review: StudyReview) -> Figure:
    first, second = review.space.names
    figure = new_figure(6.8, 4.2)
    axes = figure.subplots()
    found = cost_map(review)
    if found is not None:
        title = f"objective g of the {SOURCES[found.source]}, interpolated [1]"
        draw_map(axes, found.x, found.y, found.objective, title, "viridis")
    for source, style in _MARKS.items():
        own = [run.trial for run in review.of(source)]
        _points(axes, [t.gains[first] for t in own], [t.gains[second] for t in own], style,
                SOURCES[source])  # fmt: skip
    if review.best is not None:
        best = review.best.gains
        label = f"{review.best_words} real run"
        axes.plot(best[first], best[second], "*", color=ORANGE, markeredgecolor="k",
                  markersize=13, linestyle="none", label=label)  # fmt: skip
    axes.set_xlabel(gain_label(first, review.gain_unit(first)), parse_math=False)
    axes.set_ylabel(gain_label(second, review.gain_unit(second)), parse_math=False)
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


@in_style
def best_observed(review: StudyReview) -> Figure:
    """Draw the best real run so far, against real runs and against the cost of all runs.

    Parameters
    ----------
    review : StudyReview
        With a real run.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.

    Raises
    ------
    InputError
        There is no real run yet; or matplotlib is missing.
    """
    descent = review.descent
    if not descent.numbers:
        raise InputError("expected a study with a real run, got none; wait for the first")
    figure = new_figure(7.6, 3.2)
    left, right = figure.subplots(1, 2, sharey=True)
    count = np.arange(1.0, len(descent.numbers) + 1.0)
    for axes, x in ((left, count), (right, descent.cost)):
        axes.step(x, descent.best, where="post", color=BLUE, label=f"{review.best_words} so far")
        _points(axes, x.tolist(), descent.objective.tolist(), _MARKS["IS1"], "real runs")
    left.set(xlabel="real runs [1]", ylabel=_OBJECTIVE)
    right.set_xlabel("cost of all runs [real runs]")
    left.legend(frameon=False)
    count_along(left)
    return figure


@in_style
def sampling_cost(review: StudyReview) -> Figure:
    """Draw the cost of all runs over the queries, with each query's source.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(5.6, 3.2)
    axes = figure.subplots()
    ends = {run.query: run.cost for run in review.runs}  # the last run of each query counts
    axes.step(list(ends), list(ends.values()), where="post", color=GREY, label="all runs")
    asked = [run for run in review.runs if run.role == "query"]
    for source in ("IS1", "IS2"):
        own = [run for run in asked if run.trial.source == source]
        _points(axes, [run.query for run in own], [ends[run.query] for run in own],
                _MARKS[source], f"asked: {SOURCES[source]}")  # fmt: skip
    axes.set(xlabel=_QUERIES, ylabel="cost of all runs [real runs]", ylim=(0.0, None))
    axes.legend(frameon=False)
    count_along(axes)
    return figure


@in_style
def mismatch_and_trust(review: StudyReview) -> Figure:
    """Draw mismatch, the trust it allows, and the twin's error before and after correction.

    Parameters
    ----------
    review : StudyReview
        Of a method that corrects its twin.

    Returns
    -------
    matplotlib.figure.Figure
        Three panels over the queries.

    Raises
    ------
    InputError
        The method gave no mismatch and made no correction; or matplotlib is missing.
    """
    if not review.mismatch and not review.correction:
        raise InputError(
            f"expected a study whose method corrects its twin, got '{review.file.method}'; "
            'run one with method = "gmfbo"'
        )
    figure = new_figure(9.6, 3.0)
    left, middle, right = figure.subplots(1, 3)
    query, mismatch = mismatch_series(review)
    left.plot(query, mismatch, "o-", color=VERMILION, markersize=3.0)
    left.set(xlabel=_QUERIES, ylabel="mismatch e of the twin [1]", ylim=(0.0, None))
    middle.plot(query, [source_lengthscale(e) for e in mismatch], "o-", color=BLUE,
                markersize=3.0, label="lengthscale between the sources")  # fmt: skip
    middle.plot(query, [query_cost(e) for e in mismatch], "s--", color=PURPLE, markersize=3.0,
                label="price of a query of the twin")  # fmt: skip
    middle.set(xlabel=_QUERIES, ylabel="trust and price [1]", ylim=(0.0, 1.35))
    middle.legend(frameon=False, loc="upper left", fontsize=7.0)
    at, twin, corrected = error_series(review)
    right.plot(at, twin, "s--", color=VERMILION, markersize=3.0, label="twin")
    right.plot(at, corrected, "o-", color=BLUE, markersize=3.0, label="corrected, held out")
    signal = review.file.objective.signal
    right.set(xlabel=_QUERIES, yscale="log")
    right.set_ylabel(axis_label(f"RMS error of {words(signal)}", review.signal_unit(signal)),
                     parse_math=False)  # fmt: skip
    right.legend(frameon=False, fontsize=7.0)
    count_along(left, middle, right)
    return figure


def _points(
    axes: Axes,
    x: Sequence[float],
    y: Sequence[float],
    style: tuple[str, str, float],
    label: str,
) -> None:
    shape, colour, size = style
    if len(x):
        axes.plot(x, y, shape, color=colour, markersize=size, markeredgecolor="white",
                  markeredgewidth=0.4, linestyle="none", label=label)  # fmt: skip
