"""Gains that were run, over the interpolated cost: a map of two, or a profile along each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.pages.html_page import paragraph
from gmfbo.pages.shaded_map import shade_levels, shade_of, shade_scale, shaded_cells
from gmfbo.pages.svg_axis import Axis, LogAxis
from gmfbo.pages.svg_chart import Line, line_path
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.reports.study.interpolated_objective import InterpolatedObjective
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.run_marks import SOURCES, best_mark, mark_legend, run_mark
from gmfbo.reports.study.run_roles import Run
from gmfbo.space import Gain

Array = NDArray[np.float64]

_SIDE = 90
_PROFILE = 200
_ORDER = ("IS2", "IS3", "IS1")  # real runs on top


@dataclass(frozen=True, eq=False)
class CostMap:
    """The interpolated cost over a box of two gains.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Middle of each cell [unit of the gain].
    objective : ndarray, shape (n, n)
        Cost g, the first gain along the first axis.
    levels : ndarray, shape (SHADES - 1,)
        Costs between two shades.
    source : str
        Whose cost it is.
    runs : int
        Different gains that were run.
    """

    x: Array
    y: Array
    objective: Array
    levels: Array
    source: str
    runs: int


def cost_map(review: StudyReview) -> CostMap | None:
    """Interpolate the cost of a study of two gains.

    Returns
    -------
    CostMap or None
        None for other than two gains, or too few runs.
    """
    between = InterpolatedObjective.of(review) if len(review.space) == 2 else None
    if between is None:
        return None
    middle = (np.arange(_SIDE) + 0.5) / _SIDE
    unit = np.stack(np.meshgrid(middle, middle, indexing="ij"), axis=-1).reshape(-1, 2)
    costs = between.at(unit).reshape(_SIDE, _SIDE)
    x, y = review.space.from_unit(np.stack([middle, middle], axis=-1)).T
    return CostMap(x, y, costs, shade_levels(costs), between.source, between.runs)


def gain_map(review: StudyReview) -> str:
    """Draw the gains that were run.

    Returns
    -------
    str
        A `<figure>`: over two gains a map; otherwise for each gain the cost against it.
    """
    gains = review.space.gains
    if not gains:
        return ""
    legend = _legend(review)
    if len(gains) == 2:
        return f'<figure class="gains">{legend}{_map(review)}</figure>'
    charts = "".join(_profile(review, column) for column in range(len(gains)))
    told = ""
    if len(gains) > 1:
        told = paragraph(
            "Cost of each run against each gain; the line is the interpolated cost through the "
            "best gains.",
            "soft small",
        )
    return f'<figure class="gains">{legend}{told}<div class="columns">{charts}</div></figure>'


def _map(review: StudyReview) -> str:
    first, second = review.space.gains
    x_axis, y_axis = _axis(first, 0.0, WIDE), _axis(second, HIGH, 0.0)
    found = cost_map(review)
    under = [] if found is None else shaded_cells(found.objective, found.levels)
    marks = [
        run_mark(
            run,
            run.trial.gains[first.name],
            run.trial.gains[second.name],
            x_axis,
            y_axis,
            "" if found is None else _shade(run, found),
        )
        for source in _ORDER
        for run in review.of(source)
    ]
    best = _best(review)
    if best is not None:
        gains = best.trial.gains
        marks.append(best_mark(best, gains[first.name], gains[second.name], x_axis, y_axis))
    told = paragraph(_map_words(found), "soft small")
    chart = framed(
        x_axis,
        y_axis,
        [],
        title=f"gains that were run: {first.name} against {second.name}",
        x_label=_label(review, first),
        y_label=_label(review, second),
        style="map",
        under=under,
        over=marks,
    )
    scale = "" if found is None else shade_scale(found.objective, found.levels, "objective g [1]")
    return chart + scale + told


def _map_words(found: CostMap | None) -> str:
    if found is None:
        return "Too few runs to interpolate the cost between them."
    return (
        f"Shaded: cost of the {SOURCES[found.source]}, interpolated between {found.runs} of its "
        "runs, and white where it was not run, or only as it was before. The scale has ten shades, "
        "each with as much area of the map. A real run has the "
        "shade of its own cost: where it stands out, the twin is wrong."
    )


def _shade(run: Run, found: CostMap) -> str:
    if run.trial.source != "IS1" or run.trial.status != "ok":
        return ""
    return shade_of(run.trial.objective, found.levels)


def _profile(review: StudyReview, column: int) -> str:
    gain = review.space.gains[column]
    costs = np.array([run.trial.objective for run in review.runs])
    x_axis = _axis(gain, 0.0, WIDE)
    line = _along(review, column)
    y_axis = Axis.over([costs, line.y], HIGH, 0.0, margin=0.05)
    marks = [
        run_mark(run, run.trial.gains[gain.name], run.trial.objective, x_axis, y_axis)
        for source in _ORDER
        for run in review.of(source)
    ]
    best = _best(review)
    if best is not None:
        own = best.trial
        marks.append(best_mark(best, own.gains[gain.name], own.objective, x_axis, y_axis))
    return framed(
        x_axis,
        y_axis,
        [line_path(line, x_axis, y_axis)],
        title=f"objective against {gain.name}",
        x_label=_label(review, gain),
        y_label="objective g [1]",
        over=marks,
    )


def _along(review: StudyReview, column: int) -> Line:
    """Interpolated cost along one gain through the best gains; empty where it is not known."""
    between, best = InterpolatedObjective.of(review), _best(review)
    if between is None or best is None:
        return Line("", "spline", np.empty(0), np.empty(0))
    unit = np.repeat(review.points([best]), _PROFILE, axis=0)
    unit[:, column] = np.linspace(0.0, 1.0, _PROFILE)
    return Line("", "spline", review.space.from_unit(unit)[:, column], between.at(unit))


def _legend(review: StudyReview) -> str:
    shown: Sequence[str] = [source for source in SOURCES if review.of(source)]
    kinds = [(source, SOURCES[source]) for source in shown]
    best = [("best", f"{review.best_words} real run")] if review.best else []
    return mark_legend([*kinds, *best])


def _best(review: StudyReview) -> Run | None:
    return next((run for run in review.runs if run.trial is review.best), None)


def _label(review: StudyReview, gain: Gain) -> str:
    unit = review.gain_unit(gain.name)
    return f"{gain.name} [{unit}]" if unit else gain.name


def _axis(gain: Gain, start: float, end: float) -> Axis:
    kind = LogAxis if gain.scale == "log" else Axis
    return kind(gain.low, gain.high, start, end)
