"""Frame of a chart: axes, grid, numbers and labels that keep their size."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from gmfbo.pages.svg_axis import Axis

WIDE, HIGH = 2000.0, 1000.0
"""Units of the drawing, which is stretched to its place; strokes and letters are not."""


def framed(
    x_axis: Axis,
    y_axis: Axis,
    inside: Sequence[str],
    *,
    title: str,
    x_label: str,
    y_label: str,
    style: str = "",
    under: Sequence[str] = (),
    over: Sequence[str] = (),
) -> str:
    """Put a drawing into its frame.

    Parameters
    ----------
    x_axis, y_axis : Axis
        Over `WIDE` from the left, and over `HIGH` from below.
    inside : sequence of str
        SVG in the drawing's units, drawn in order upon the grid.
    title : str
        Text for a screen reader.
    x_label, y_label : str
        Quantities with their units; no `x_label`, no numbers under the x axis.
    style : str
        Class in the page's style, which gives the height.
    under : sequence of str
        SVG in the drawing's units below the grid.
    over : sequence of str
        SVG with positions in shares of the drawing and sizes in pixels, such as marks.

    Returns
    -------
    str
        A `<div class="chart">` that is as wide as its place. `data-x` and `data-y` hold the
        ends of the axes, for a script that zooms.
    """
    told = f'<p class="y-label">{escape(y_label)}</p>'
    below = f'<p class="x-label">{escape(x_label)}</p>' if x_label else ""
    shape = f"chart {style}".strip() + ("" if x_label else " bare")
    drawn = [*under, *_grid(x_axis, y_axis), *inside]
    return (
        f'<div class="{shape}" data-x="{x_axis.low:.9g} {x_axis.high:.9g}" '
        f'data-y="{y_axis.low:.9g} {y_axis.high:.9g}">{told}'
        f'<svg class="plot" role="img" aria-label="{escape(title)}">'
        f'<svg class="area" viewBox="0 0 {WIDE:g} {HIGH:g}" preserveAspectRatio="none">'
        f"{''.join(drawn)}</svg>{_tick_texts(x_axis, y_axis, bool(x_label))}{''.join(over)}</svg>"
        f"{below}</div>"
    )


def _grid(x_axis: Axis, y_axis: Axis) -> list[str]:
    along = [f"M{float(x_axis.at(tick)):.0f} 0V{HIGH:g}" for tick in x_axis.ticks()]
    across = [f"M0 {float(y_axis.at(tick)):.0f}H{WIDE:g}" for tick in y_axis.ticks()]
    return [
        f'<path class="grid" d="{"".join(along + across)}"/>',
        f'<path class="axis" d="M0 0V{HIGH:g}H{WIDE:g}"/>',
    ]


def _tick_texts(x_axis: Axis, y_axis: Axis, below: bool) -> str:
    parts = []
    for tick, text in zip(y_axis.ticks(), y_axis.words(), strict=True):
        share = 100.0 * float(y_axis.at(tick)) / HIGH
        parts.append(f'<text class="y-tick" x="-8" dy="4" y="{share:.2f}%">{escape(text)}</text>')
    for tick, text in zip(x_axis.ticks(), x_axis.words(), strict=True) if below else ():
        share = 100.0 * float(x_axis.at(tick)) / WIDE
        parts.append(
            f'<text class="x-tick" x="{share:.2f}%" y="100%" dy="17">{escape(text)}</text>'
        )
    return f'<g class="ticks">{"".join(parts)}</g>'
