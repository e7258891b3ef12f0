"""Line charts as SVG text: axes, units, bands; colours come from the page's style."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WIDTH, HEIGHT = 640.0, 270.0
LEFT, RIGHT, TOP, BOTTOM = 66.0, 14.0, 30.0, 40.0
BUCKETS = 400  # a lowest and a highest point each: more than a screen's pixels tell apart


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
    band: Band | None = None,
    windows: Sequence[tuple[float, float]] = (),
) -> str:
    """Draw lines over one axis.

    Parameters
    ----------
    lines : sequence of Line
        Drawn in order, the last on top.
    title : str
        What a screen reader says.
    x_label, y_label : str
        Quantities with their units.
    band : Band, optional
        Area below the lines, such as a 95 % band.
    windows : sequence of (float, float)
        Stretches of the x axis to shade.

    Returns
    -------
    str
        An `<svg>` element, 640 by 270, which scales with its container.
    """
    ends = [] if band is None else [band.low, band.high]
    x_axis = _Axis.over([line.x for line in lines], LEFT, WIDTH - RIGHT, margin=0.0)
    y_axis = _Axis.over([*(line.y for line in lines), *ends], HEIGHT - BOTTOM, TOP, margin=0.04)
    parts = [
        f'<svg class="chart" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" '
        f'aria-label="{escape(title)}">',
        *(_window(x_axis, start, end) for start, end in windows),
        *_grid(x_axis, y_axis),
        f'<text class="label" x="{LEFT:g}" y="16">{escape(y_label)}</text>',
        f'<text class="label" x="{WIDTH - RIGHT:g}" y="{HEIGHT - 4:g}" text-anchor="end">'
        f"{escape(x_label)}</text>",
    ]
    if band is not None:
        parts.append(_band(band, x_axis, y_axis))
    parts += [_path(line, x_axis, y_axis) for line in lines]
    return "".join([*parts, "</svg>"])


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
    entries = "".join(
        f'<li><svg viewBox="0 0 34 10" aria-hidden="true"><path class="line {line.style}" '
        f'd="M1 5H33"/></svg>{escape(line.name)}</li>'
        for line in lines
    )
    return f'<ul class="legend">{entries}</ul>'


@dataclass(frozen=True)
class _Axis:
    """A stretch of values laid over a stretch of the drawing."""

    low: float
    high: float
    start: float
    end: float

    @classmethod
    def over(cls, values: Sequence[Array], start: float, end: float, margin: float) -> _Axis:
        together = np.concatenate([np.asarray(one, dtype=np.float64) for one in values])
        finite = together[np.isfinite(together)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        # A constant still needs an axis; its own size, else one, is as good as any.
        spread = (high - low) or abs(high) or 1.0
        if high == low:
            margin = 0.5
        return cls(low - margin * spread, high + margin * spread, start, end)

    def at(self, value: Array | float) -> Array:
        share = (np.asarray(value, dtype=np.float64) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """About five round values: 1, 2 or 5 times a power of ten apart."""
        rough = (self.high - self.low) / 5.0
        power = 10.0 ** np.floor(np.log10(rough))
        step = float(next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= rough))
        first, last = np.ceil(self.low / step - 1e-9), np.floor(self.high / step + 1e-9)
        return [float(step * k) for k in np.arange(first, last + 1.0)]


def _tick_texts(ticks: Sequence[float]) -> list[str]:
    """As few decimals as tell neighbours apart; powers of ten for very large or small values."""
    largest = max((abs(tick) for tick in ticks), default=0.0)
    if len(ticks) < 2 or not 1e-4 <= largest < 1e6:
        return [f"{tick + 0.0:.4g}" for tick in ticks]
    decimals = max(0, -int(np.floor(np.log10(ticks[1] - ticks[0]) + 1e-9)))
    return [f"{tick + 0.0:.{decimals}f}" for tick in ticks]


def _grid(x_axis: _Axis, y_axis: _Axis) -> list[str]:
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    parts = []
    ticks = x_axis.ticks()
    for tick, text in zip(ticks, _tick_texts(ticks), strict=True):
        x = float(x_axis.at(tick))
        parts.append(f'<path class="grid" d="M{x:.1f} {TOP:g}V{bottom:g}"/>')
        parts.append(f'<text x="{x:.1f}" y="{bottom + 17:g}" text-anchor="middle">{text}</text>')
    ticks = y_axis.ticks()
    for tick, text in zip(ticks, _tick_texts(ticks), strict=True):
        y = float(y_axis.at(tick))
        parts.append(f'<path class="grid" d="M{LEFT:g} {y:.1f}H{right:g}"/>')
        parts.append(f'<text x="{LEFT - 7:g}" y="{y + 4.5:.1f}" text-anchor="end">{text}</text>')
    parts.append(f'<path class="axis" d="M{LEFT:g} {TOP:g}V{bottom:g}H{right:g}"/>')
    return parts


def _window(x_axis: _Axis, start: float, end: float) -> str:
    left = max(float(x_axis.at(start)), LEFT)
    right = min(float(x_axis.at(end)), WIDTH - RIGHT)
    if right <= left:
        return ""
    # A window of a few milliseconds would be invisible.
    wide = max(right - left, 2.0)
    height = HEIGHT - BOTTOM - TOP
    return (
        f'<rect class="window" x="{left:.1f}" y="{TOP:g}" width="{wide:.1f}" height="{height:g}"/>'
    )


def _band(band: Band, x_axis: _Axis, y_axis: _Axis) -> str:
    x = np.concatenate([band.x, band.x[::-1]])
    y = np.concatenate([band.low, band.high[::-1]])
    return f'<path class="band" d="M{_points(x_axis.at(x), y_axis.at(y))}Z"/>'


def _path(line: Line, x_axis: _Axis, y_axis: _Axis) -> str:
    pieces = []
    known = np.isfinite(line.y) & np.isfinite(line.x)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        x, y = thinned(line.x[start:end], line.y[start:end])
        pieces.append("M" + _points(x_axis.at(x), y_axis.at(y)))
    return f'<path class="line {line.style}" d="{"".join(pieces)}"/>' if pieces else ""


def _points(x: Array, y: Array) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """Keep the lowest and the highest point of each of 400 stretches, so that no peak is lost.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Points in order, finite.

    Returns
    -------
    x, y : ndarray, shape (m,)
        At most 802 of them, in order, both ends among them.
    """
    if x.size <= 2 * BUCKETS:
        return x, y
    bounds = np.linspace(0, x.size, BUCKETS + 1).astype(int)
    kept = {0, x.size - 1}
    for start, end in pairwise(bounds.tolist()):
        kept |= {int(start + np.argmin(y[start:end])), int(start + np.argmax(y[start:end]))}
    rows = np.array(sorted(kept))
    return x[rows], y[rows]
