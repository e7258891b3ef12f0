"""Line charts that stretch with the page: SVG text whose letters keep their size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from gmfbo.pages.svg_axis import Array, Axis
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.pages.thinning import thinned_rows

MOST_BUCKETS = 400  # a lowest and a highest point each: more than a screen's pixels tell apart


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a chart; n points.

    Attributes
    ----------
    name : str
        Name in the legend.
    style : str
        Class in the page's style, which gives colour and dashes.
    x, y : ndarray, shape (n,)
        Points in order; the line is interrupted where y is NaN.
    whole : bool
        Whether it is drawn as finely as a screen shows, in a chart of few points too.
    """

    name: str
    style: str
    x: Array
    y: Array
    whole: bool = False


@dataclass(frozen=True, eq=False)
class Band:
    """Area between two lines; n points.

    Attributes
    ----------
    x, low, high : ndarray, shape (n,)
        Its ends, finite.
    style : str
        Class in the page's style, besides that of all bands.
    """

    x: Array
    low: Array
    high: Array
    style: str = ""


def line_chart(
    lines: Sequence[Line],
    *,
    title: str,
    x_label: str,
    y_label: str,
    style: str = "",
    band: Band | None = None,
    windows: Sequence[tuple[float, float]] = (),
    buckets: int = MOST_BUCKETS,
) -> str:
    """Draw lines over one axis.

    Parameters
    ----------
    lines : sequence of Line
        Drawn in order, the last on top.
    title : str
        Text for a screen reader.
    x_label, y_label : str
        Quantities with their units; no `x_label`, no numbers under the x axis.
    style : str
        Class in the page's style, which gives the height.
    band : Band, optional
        Band drawn below the lines, such as a 95 % interval.
    windows : sequence of (float, float)
        Stretches of the x axis to shade.
    buckets : int
        Stretches of a line, of each of which the lowest and highest point are kept.

    Returns
    -------
    str
        A `<div class="chart">` that is as wide as its place. `data-x` and `data-y` hold the
        ends of the axes, for a script that zooms.
    """
    ends = [] if band is None else [band.low, band.high]
    x_axis = Axis.over([line.x for line in lines], 0.0, WIDE, margin=0.0)
    y_axis = Axis.over([*(line.y for line in lines), *ends], HIGH, 0.0, margin=0.05)
    drawn = [_window_rectangle(x_axis, start, end) for start, end in windows]
    if band is not None:
        drawn.append(band_path(band, x_axis, y_axis))
    drawn += [line_path(line, x_axis, y_axis, buckets) for line in lines]
    return framed(x_axis, y_axis, drawn, title=title, x_label=x_label, y_label=y_label, style=style)


def legend(lines: Sequence[Line]) -> str:
    """Legend of the lines as an HTML list.

    Returns
    -------
    str
        A `<ul>` element.
    """
    entries = "".join(f"<li>{swatch(line.style)}{escape(line.name)}</li>" for line in lines)
    return f'<ul class="legend">{entries}</ul>'


def swatch(style: str) -> str:
    """Draw a piece of a line, as it looks in a chart."""
    return (
        f'<svg class="swatch" viewBox="0 0 26 10" aria-hidden="true">'
        f'<path class="line {style}" d="M1 5H25"/></svg>'
    )


def _window_rectangle(x_axis: Axis, start: float, end: float) -> str:
    """Shade a stretch of the x axis; nothing for one that lies outside."""
    left, right = max(float(x_axis.at(start)), 0.0), min(float(x_axis.at(end)), WIDE)
    if right <= left:
        return ""
    # A window of a few milliseconds would be invisible.
    wide = max(right - left, 6.0)
    return (
        f'<rect class="window" x="{left:.0f}" y="0" width="{wide:.0f}" height="{HIGH:g}" '
        f'data-x="{start:.9g} {end:.9g}"/>'
    )


def band_path(band: Band, x_axis: Axis, y_axis: Axis) -> str:
    """Draw a band."""
    x = np.concatenate([band.x, band.x[::-1]])
    y = np.concatenate([band.low, band.high[::-1]])
    kind = f"band {band.style}".strip()
    return f'<path class="{kind}" d="M{_points(x_axis.at(x), y_axis.at(y))}Z"/>'


def line_path(line: Line, x_axis: Axis, y_axis: Axis, buckets: int = MOST_BUCKETS) -> str:
    """Draw a line; nothing for one without points.

    Parameters
    ----------
    line : Line
        The line.
    x_axis, y_axis : Axis
        Of the chart.
    buckets : int
        Stretches, of each of which the lowest and highest point are kept.
    """
    pieces = []
    known = np.isfinite(line.y) & np.isfinite(line.x)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    buckets = MOST_BUCKETS if line.whole else buckets
    for start, end in edges.reshape(-1, 2):
        rows = thinned_rows([line.y[start:end]], buckets)
        x, y = line.x[start:end][rows], line.y[start:end][rows]
        pieces.append("M" + _points(x_axis.at(x), y_axis.at(y)))
    return f'<path class="line {line.style}" d="{"".join(pieces)}"/>' if pieces else ""


def _points(x: Array, y: Array) -> str:
    return "L".join(f"{a:.0f} {b:.0f}" for a, b in zip(x, y, strict=True))
