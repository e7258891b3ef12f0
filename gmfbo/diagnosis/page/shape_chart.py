"""Chart of what acts at a port: the curve inferred without a name, and the named law over it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gmfbo.pages.html_page import paragraph
from gmfbo.pages.signal_panel import axis_words
from gmfbo.pages.svg_axis import Axis
from gmfbo.pages.svg_chart import Band, Line, band_path, legend, line_path
from gmfbo.pages.svg_frame import HIGH, WIDE, framed
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.whereabouts import Shape


def inferred_shape(diagnosis: Findings) -> str:
    """Draw what acts at a port, with a sentence that says what is seen; nothing where unknown.

    Parameters
    ----------
    diagnosis : Findings
        Result of the diagnosis.
    """
    shape = diagnosis.shape or diagnosis.latent
    if shape is None:
        return ""
    what = f"What is missing at the {words(shape.port)} port over the {words(shape.against)}"
    if shape.law:
        told = (
            f"{what}. The curve was fitted point by point, with no law in mind, to what the twin "
            "with its refitted values leaves. The dashed line is the named law. They agree where "
            "the law has the right shape."
        )
    else:
        told = f"{what}, fitted as a smooth function with no law in mind; its band is of noise."
        if diagnosis.shape is not None:
            told += (
                " It acts beside the named laws."
                if diagnosis.effects
                else " No effect in the library has this shape."
            )
    return paragraph(told) + _chart(shape)


def _chart(shape: Shape) -> str:
    x, y = np.array(shape.x), np.array(shape.y)
    low, high = np.array(shape.y_low), np.array(shape.y_high)
    known = np.isfinite(low) & np.isfinite(high)
    lines = [Line("fitted without a law, 95 % band", "after", x, y)]
    if shape.law_x:
        law = Line(f"named law: {words(shape.law)}", "law-line", *_law(shape))
        lines.append(law)
    # A knot that the motion hardly reaches has a band as wide as the prior: it gets no axis.
    x_axis = Axis.over([line.x for line in lines], 0.0, WIDE, margin=0.0)
    y_axis = Axis.over([*(line.y for line in lines), np.zeros(1)], HIGH, 0.0, margin=0.15)
    drawn = [line_path(line, x_axis, y_axis) for line in lines]
    if known.any():
        drawn.insert(0, band_path(Band(x[known], low[known], high[known]), x_axis, y_axis))
    chart = framed(
        x_axis,
        y_axis,
        drawn,
        title=f"missing {words(shape.port)} against {words(shape.against)}",
        x_label=axis_words(words(shape.against), shape.unit_x),
        y_label=axis_words(f"missing at the {words(shape.port)} port", shape.unit_y),
        style="shape",
    )
    return f"<figure>{legend(lines)}{chart}</figure>"


def _law(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    return np.array(shape.law_x), np.array(shape.law_y)
