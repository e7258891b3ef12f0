"""Figures of a comparison of methods: landscape, sampling cost, and simple regret."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gmfbo.reports.comparison.charts import ARRIVED, LEAST_REGRET
from gmfbo.reports.comparison.curves import Curve, Landscape
from gmfbo.reports.figures.figure_map import draw_map
from gmfbo.reports.figures.figure_style import (
    DASHES,
    METHOD_COLOURS,
    count_along,
    gain_label,
    in_style,
    new_figure,
    save_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_REAL_RUNS = "real runs, initial ones counted [1]"


def draw_comparison(
    curves: Sequence[Curve], landscape: Landscape | None, folder: Path
) -> list[Path]:
    """Draw all figures of a comparison, each as SVG, PDF and PNG.

    Parameters
    ----------
    curves : sequence of Curve
        Of all methods.
    landscape : Landscape or None
        None draws no landscape.
    folder : Path
        Made where it is missing.

    Returns
    -------
    list of Path
        Of the SVG files.

    Raises
    ------
    InputError
        matplotlib is missing, or a file cannot be written.
    """
    figures = {"sampling_cost": sampling_cost(curves), "best_observed": best_observed(curves)}
    if landscape is not None:
        figures["landscape"] = landscape_figure(landscape)
    for name, figure in figures.items():
        for ending in (".svg", ".pdf", ".png"):
            save_figure(figure, folder / f"{name}{ending}")
    return [folder / f"{name}.svg" for name in figures]


@in_style
def landscape_figure(landscape: Landscape) -> Figure:
    """Draw the true objective over two gains, and the relative error of the twin.

    Parameters
    ----------
    landscape : Landscape
        Of a comparison.

    Returns
    -------
    matplotlib.figure.Figure
        Two maps with the best gains of the plant.
    """
    figure = new_figure(8.4, 3.4)
    left, right = figure.subplots(1, 2, sharey=True)
    shown = (
        (left, landscape.objective, "true objective g of the plant [1]", "viridis"),
        (right, landscape.error, "relative error of the twin's cost G [%]", "magma_r"),
    )
    for axes, values, title, colours in shown:
        draw_map(axes, landscape.x, landscape.y, values, title, colours)
        axes.set_xlabel(gain_label(landscape.names[0]), parse_math=False)
    left.set_ylabel(gain_label(landscape.names[1]), parse_math=False)
    row, column = np.unravel_index(np.argmin(landscape.objective), landscape.objective.shape)
    for axes in (left, right):
        axes.plot(landscape.x[row], landscape.y[column], "w*", markeredgecolor="k", markersize=10)
    figure.suptitle(f"seed {landscape.seed}; star: best gains of the plant", fontsize=8.0)
    return figure


@in_style
def sampling_cost(curves: Sequence[Curve]) -> Figure:
    """Draw the cost of all runs against queries, a mean over seeds with its 95 % interval.

    Parameters
    ----------
    curves : sequence of Curve
        Of all methods; those named `cost` are drawn.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    figure = new_figure(6.4, 3.6)
    axes = figure.subplots()
    _lines(axes, curves, "cost")
    axes.set(
        xlabel="queries after the initial data [1]",
        ylabel="cost of all runs [real runs]",
        ylim=(0.0, None),
    )
    axes.set_title("a real run counts 1, a twin run or a corrected one 0.1", fontsize=9.0)
    count_along(axes)
    figure.legend(loc="outside right upper", frameon=False)
    return figure


@in_style
def best_observed(curves: Sequence[Curve]) -> Figure:
    """Draw cost and simple regret of the best real run so far, against real runs.

    Parameters
    ----------
    curves : sequence of Curve
        Of all methods; those named `objective` and `regret` are drawn.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels; means over seeds with their 95 % intervals.
    """
    figure = new_figure(8.4, 3.8)
    left, right = figure.subplots(1, 2)
    _lines(left, curves, "objective")
    _lines(right, curves, "regret")
    right.axhline(ARRIVED, color="k", linewidth=0.8, linestyle=":")
    right.set_yscale("log")
    right.set_ylim(LEAST_REGRET, None)
    left.set(ylabel="best observed objective g [1]", xlabel=_REAL_RUNS)
    right.set(ylabel="of the way from the optimum to the median [1]", xlabel=_REAL_RUNS)
    count_along(left, right)
    figure.legend(*left.get_legend_handles_labels(), loc="outside right upper", frameon=False)
    return figure


def _lines(axes: Axes, curves: Sequence[Curve], name: str) -> None:
    for number, curve in enumerate(curve for curve in curves if curve.name == name):
        colour = METHOD_COLOURS[number % len(METHOD_COLOURS)]
        dashes = DASHES[number // len(METHOD_COLOURS) % len(DASHES)]
        axes.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(
            curve.x,
            curve.mean,
            dashes,
            color=colour,
            linewidth=1.4,
            label=f"{curve.method} ({curve.seeds})",
        )
