"""Figures of a comparison of methods: landscape, sampling cost, and the way to the optimum."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gmfbo.reports.comparison_curves import Curve, Landscape

ARRIVED = 0.02
"""Regret at which a method counts as arrived."""

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#8c6d00", "#7f3fbf", "#555555")
"""Okabe and Ito 2008, told apart by colour-blind readers, darkened for lines."""

_DASHES = ("-", "--", "-.", ":")


def draw_comparison(
    curves: Sequence[Curve], landscape: Landscape | None, folder: Path
) -> list[Path]:
    """Draw all figures of a comparison, each as SVG and PNG.

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
    """
    folder.mkdir(parents=True, exist_ok=True)
    # Letters stay letters, and the same tables give the same bytes.
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "gmfbo", "font.size": 9.0}):
        figures = {"sampling_cost": _cost(curves), "best_observed": _best(curves)}
        if landscape is not None:
            figures["landscape"] = _landscape(landscape)
        for name, figure in figures.items():
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
            figure.savefig(folder / f"{name}.png", dpi=150)
    return [folder / f"{name}.svg" for name in figures]


def _landscape(landscape: Landscape) -> Figure:
    figure = Figure((8.4, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    # Costs rise steeply at the box's edge; levels by rank show the valley too.
    shown: tuple[tuple[Axes, NDArray[np.float64], str, str], ...] = (
        (left, landscape.objective, "true objective g of the plant", "viridis"),
        (right, landscape.error, "relative error of the twin's cost [%]", "magma_r"),
    )
    for axes, values, title, colours in shown:
        levels = np.unique(np.quantile(values, np.linspace(0.0, 1.0, 16)))
        if levels.size < 3:
            levels = np.linspace(levels[0] - 0.5, levels[-1] + 0.5, 3)
        norm = mpl.colors.BoundaryNorm(levels, 256)
        filled = axes.contourf(
            landscape.x, landscape.y, values.T, levels=levels, cmap=colours, norm=norm
        )
        figure.colorbar(filled, ax=axes, format="%.3g", ticks=levels[::3])
        axes.set(title=title, xlabel=landscape.names[0])
    left.set_ylabel(landscape.names[1])
    row, column = np.unravel_index(np.argmin(landscape.objective), landscape.objective.shape)
    for axes in (left, right):
        axes.plot(landscape.x[row], landscape.y[column], "w*", markeredgecolor="k", markersize=10)
    figure.suptitle(f"seed {landscape.seed}; star: best gains of the plant", fontsize=8.0)
    return figure


def _cost(curves: Sequence[Curve]) -> Figure:
    figure = Figure((6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    _lines(axes, curves, "cost")
    axes.set(
        xlabel="queries after the initial data",
        ylabel="cost of all runs [real runs]",
        title="a real run counts 1, a twin run or a corrected one 0.1",
        ylim=(0.0, None),
    )
    figure.legend(loc="outside right upper", frameon=False)
    return figure


def _best(curves: Sequence[Curve]) -> Figure:
    figure = Figure((8.4, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    _lines(left, curves, "objective")
    _lines(right, curves, "regret")
    right.axhline(ARRIVED, color="k", linewidth=0.8, linestyle=":")
    right.set_yscale("log")
    # Below a thousandth of the way differences mean nothing; zero cannot be drawn.
    right.set_ylim(1e-3, None)
    left.set(ylabel="best observed objective g", xlabel="real runs, initial ones counted")
    right.set(
        ylabel="of the way from the optimum to the median",
        xlabel="real runs, initial ones counted",
    )
    figure.legend(*left.get_legend_handles_labels(), loc="outside right upper", frameon=False)
    return figure


def _lines(axes: Axes, curves: Sequence[Curve], name: str) -> None:
    """Draw each method's mean, its 95 % interval as a band."""
    for number, curve in enumerate(curve for curve in curves if curve.name == name):
        colour = _COLOURS[number % len(_COLOURS)]
        dashes = _DASHES[number // len(_COLOURS) % len(_DASHES)]
        axes.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(
            curve.x,
            curve.mean,
            dashes,
            color=colour,
            linewidth=1.4,
            label=f"{curve.method} ({curve.seeds})",
        )
    axes.grid(visible=True, linewidth=0.4, alpha=0.5)
