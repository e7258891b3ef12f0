"""Line charts that stretch with the page: SVG text whose letters keep their size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WIDE, HIGH = 2000.0, 1000.0
"""Units of the drawing, which is stretched to its place; strokes and letters are not."""

MOST_BUCKETS = 400  # a lowest and a highest point each: more than a screen's pixels tell apart


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a chart; n points.

    Attributes
    ----------
    name : str
        What the legend says.
    style : str
        Class in the page's style, which gives colour and dashes.
    x, y : ndarray, shape (n,)
        Points in order; the line is interrupted where y is NaN.
    """

    name: str
    style: str
    x: Array
    y: Array


@dataclass(frozen=True, eq=False)
class Band:
    """Area between two lines; n points.

    Attributes
    ----------
    x, low, high : ndarray, shape (n,)
        Its ends, finite.
    """

    x: Array
    low: Array
    high: Array


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
        What a screen reader says.
    x_label, y_label : str
        Quantities with their units; no `x_label`, no numbers under the x axis.
    style : str
        Class in the page's style, which gives the height.
    band : Band, optional
        Area below the lines, such as a 95 % band.
    windows : sequence of (float, float)
        Stretches of the x axis to shade.
    buckets : int
        Stretches of a line of which the lowest and the highest point are kept.

    Returns
    -------
    str
        A `<div class="chart">` that is as wide as its place. `data-x` and `data-y` hold the
        ends of the axes, for a script that zooms.
    """
    ends = [] if band is None else [band.low, band.high]
    x_axis = Axis.over([line.x for line in lines], 0.0, WIDE, margin=0.0)
    y_axis = Axis.over([*(line.y for line in lines), *ends], HIGH, 0.0, margin=0.05)
    drawn = [_window(x_axis, start, end) for start, end in windows]
    drawn += _grid(x_axis, y_axis)
    if band is not None:
        drawn.append(_band(band, x_axis, y_axis))
    drawn += [_path(line, x_axis, y_axis, buckets) for line in lines]
    told = f'<p class="y-label">{escape(y_label)}</p>'
    under = f'<p class="x-label">{escape(x_label)}</p>' if x_label else ""
    shape = f"chart {style}".strip() + ("" if x_label else " bare")
    return (
        f'<div class="{shape}" data-x="{x_axis.low:.9g} {x_axis.high:.9g}" '
        f'data-y="{y_axis.low:.9g} {y_axis.high:.9g}">{told}'
        f'<svg class="plot" role="img" aria-label="{escape(title)}">'
        f'<svg class="area" viewBox="0 0 {WIDE:g} {HIGH:g}" preserveAspectRatio="none">'
        f"{''.join(drawn)}</svg>{_tick_texts(x_axis, y_axis, bool(x_label))}</svg>{under}</div>"
    )


def legend(lines: Sequence[Line]) -> str:
    """Name each line beside a piece of it, as an HTML list.

    Parameters
    ----------
    lines : sequence of Line
        Those of a chart.

    Returns
    -------
    str
        A `<ul>` element.
    """
    entries = "".join(f"<li>{swatch(line.style)}{escape(line.name)}</li>" for line in lines)
    return f'<ul class="legend">{entries}</ul>'


def swatch(style: str) -> str:
    """Draw a piece of a line, as it looks in a chart.

    Parameters
    ----------
    style : str
        Class in the page's style.
    """
    return (
        f'<svg class="swatch" viewBox="0 0 26 10" aria-hidden="true">'
        f'<path class="line {style}" d="M1 5H25"/></svg>'
    )


@dataclass(frozen=True)
class Axis:
    """A stretch of values laid over a stretch of the drawing.

    Attributes
    ----------
    low, high : float
        Ends of the values.
    start, end : float
        Where they lie in the drawing.
    """

    low: float
    high: float
    start: float
    end: float

    @classmethod
    def over(cls, values: Sequence[Array], start: float, end: float, margin: float) -> Axis:
        """Span all finite values and a share of their spread on either side.

        Parameters
        ----------
        values : sequence of ndarray
            What has to fit.
        start, end : float
            Where the ends lie in the drawing.
        margin : float
            Share of the spread, dimensionless.
        """
        together = np.concatenate([np.asarray(one, dtype=np.float64) for one in values])
        finite = together[np.isfinite(together)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        # A constant still needs an axis; its own size, else one, is as good as any.
        spread = (high - low) or abs(high) or 1.0
        if high == low:
            margin = 0.5
        return cls(low - margin * spread, high + margin * spread, start, end)

    def at(self, value: Array | float) -> Array:
        """Place of a value in the drawing."""
        share = (np.asarray(value, dtype=np.float64) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """About four round values: 1, 2 or 5 times a power of ten apart."""
        rough = (self.high - self.low) / 5.0
        power = 10.0 ** np.floor(np.log10(rough))
        step = float(next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough))
        first, last = np.ceil(self.low / step - 1e-9), np.floor(self.high / step + 1e-9)
        return [float(step * k) for k in np.arange(first, last + 1.0)]


def tick_words(ticks: Sequence[float]) -> list[str]:
    """As few decimals as tell neighbours apart; powers of ten for very large or small values.

    Parameters
    ----------
    ticks : sequence of float
        Evenly spaced, rising.
    """
    largest = max((abs(tick) for tick in ticks), default=0.0)
    if len(ticks) < 2 or not 1e-4 <= largest < 1e6:
        return [f"{tick + 0.0:.4g}" for tick in ticks]
    decimals = max(0, -int(np.floor(np.log10(ticks[1] - ticks[0]) + 1e-9)))
    return [f"{tick + 0.0:.{decimals}f}" for tick in ticks]


def _grid(x_axis: Axis, y_axis: Axis) -> list[str]:
    along = [f"M{float(x_axis.at(tick)):.0f} 0V{HIGH:g}" for tick in x_axis.ticks()]
    across = [f"M0 {float(y_axis.at(tick)):.0f}H{WIDE:g}" for tick in y_axis.ticks()]
    return [
        f'<path class="grid" d="{"".join(along + across)}"/>',
        f'<path class="axis" d="M0 0V{HIGH:g}H{WIDE:g}"/>',
    ]


def _tick_texts(x_axis: Axis, y_axis: Axis, below: bool) -> str:
    parts = []
    ticks = y_axis.ticks()
    for tick, text in zip(ticks, tick_words(ticks), strict=True):
        share = 100.0 * float(y_axis.at(tick)) / HIGH
        parts.append(f'<text class="y-tick" x="-8" dy="4" y="{share:.2f}%">{text}</text>')
    ticks = x_axis.ticks() if below else []
    for tick, text in zip(ticks, tick_words(ticks), strict=True):
        share = 100.0 * float(x_axis.at(tick)) / WIDE
        parts.append(f'<text class="x-tick" x="{share:.2f}%" y="100%" dy="17">{text}</text>')
    return f'<g class="ticks">{"".join(parts)}</g>'


def _window(x_axis: Axis, start: float, end: float) -> str:
    left, right = max(float(x_axis.at(start)), 0.0), min(float(x_axis.at(end)), WIDE)
    if right <= left:
        return ""
    # A window of a few milliseconds would be invisible.
    wide = max(right - left, 6.0)
    return (
        f'<rect class="window" x="{left:.0f}" y="0" width="{wide:.0f}" height="{HIGH:g}" '
        f'data-x="{start:.9g} {end:.9g}"/>'
    )


def _band(band: Band, x_axis: Axis, y_axis: Axis) -> str:
    x = np.concatenate([band.x, band.x[::-1]])
    y = np.concatenate([band.low, band.high[::-1]])
    return f'<path class="band" d="M{_points(x_axis.at(x), y_axis.at(y))}Z"/>'


def _path(line: Line, x_axis: Axis, y_axis: Axis, buckets: int) -> str:
    pieces = []
    known = np.isfinite(line.y) & np.isfinite(line.x)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        rows = thinned_rows([line.y[start:end]], buckets)
        x, y = line.x[start:end][rows], line.y[start:end][rows]
        pieces.append("M" + _points(x_axis.at(x), y_axis.at(y)))
    return f'<path class="line {line.style}" d="{"".join(pieces)}"/>' if pieces else ""


def _points(x: Array, y: Array) -> str:
    return "L".join(f"{a:.0f} {b:.0f}" for a, b in zip(x, y, strict=True))


def thinned_rows(columns: Sequence[Array], buckets: int) -> NDArray[np.intp]:
    """Rows with the lowest and highest value of each column in each stretch: no peak is lost.

    Parameters
    ----------
    columns : sequence of ndarray, shape (n,)
        Of the same rows; what is not finite is not looked at.
    buckets : int
        Stretches.

    Returns
    -------
    ndarray, shape (m,)
        Rising, both ends among them; all rows where there are few.
    """
    n = columns[0].size
    if n <= 2 * buckets * len(columns):
        return np.arange(n)
    size = -(-n // buckets)
    starts = np.arange(0, n, size)
    kept = [np.array([0, n - 1])]
    for column in columns:
        # What pads the last stretch is never an extreme; of a stretch of NaN the start is kept.
        for sign in (1.0, -1.0):
            judged = np.full(starts.size * size, np.inf)
            judged[:n] = np.where(np.isfinite(column), sign * column, np.inf)
            kept.append(starts + judged.reshape(-1, size).argmin(axis=1))
    return np.unique(np.concatenate(kept))
