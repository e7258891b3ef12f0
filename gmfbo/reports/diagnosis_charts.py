"""Charts of a diagnosis: a recording before and after, and the shape of what has no name."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from gmfbo.diagnosis.plain_words import unit_words, words
from gmfbo.reports.svg_chart import Band, Line, legend, line_chart

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.curve import Curve
    from gmfbo.diagnosis.whereabouts import Shape


def recordings_to_show(diagnosis: Diagnosis) -> list[str]:
    """Return the recordings that have curves: held-out ones first, the most telling in front.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.

    Returns
    -------
    list of str
        Their names.
    """
    names = list(dict.fromkeys(curve.recording for curve in diagnosis.curves))
    gains = diagnosis.effects[0].evidence_per_recording if diagnosis.effects else {}
    held_out = set(diagnosis.fit.held_out)
    return sorted(names, key=lambda name: (name not in held_out, -gains.get(name, 0.0)))


def before_and_after_charts(diagnosis: Diagnosis) -> str:
    """Draw each signal and its error, with and without the physics.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found; without curves there is nothing to draw.

    Returns
    -------
    str
        HTML: the first held-out recording open, the others folded.
    """
    parts = []
    for position, name in enumerate(recordings_to_show(diagnosis)):
        unseen = name in diagnosis.fit.held_out
        title = f"{name}, {'unseen by the fit' if unseen else 'fitted on'}"
        charts = "".join(
            _figures(diagnosis, curve) for curve in diagnosis.curves if curve.recording == name
        )
        shaded = any(window.recording == name for window in diagnosis.location.times)
        told = '<p class="soft">Shaded: where the mismatch shows most.</p>' if shaded else ""
        grid = f'{told}<div class="charts">{charts}</div>'
        if position == 0:
            parts.append(f"<h3>{escape(title)}</h3>{grid}")
        else:
            parts.append(f"<details><summary>{escape(title)}</summary>{grid}</details>")
    return "".join(parts)


def shape_chart(shape: Shape) -> str:
    """Draw the inferred signal with its band.

    Parameters
    ----------
    shape : Shape
        The signal against a state.

    Returns
    -------
    str
        A `<figure>` element.
    """
    x, y = np.array(shape.x), np.array(shape.y)
    low, high = np.array(shape.y_low), np.array(shape.y_high)
    known = np.isfinite(low) & np.isfinite(high)
    lines = [Line("inferred, with its 95 % band", "after", x, y)]
    chart = line_chart(
        lines,
        title=f"missing {words(shape.port)} against {words(shape.against)}",
        x_label=_axis(words(shape.against), shape.unit_x),
        y_label=_axis(f"missing at the {words(shape.port)} port", shape.unit_y),
        band=Band(x[known], low[known], high[known]) if known.any() else None,
    )
    return f"<figure>{legend(lines)}{chart}</figure>"


def _figures(diagnosis: Diagnosis, curve: Curve) -> str:
    """One signal, and its error on an axis of its own: a loop hides errors in the signal."""
    windows = [
        (window.start, window.end)
        for window in diagnosis.location.times
        if window.recording == curve.recording
    ]
    signal = [
        Line("recorded", "recorded", curve.time, curve.recorded),
        Line("nominal", "nominal", curve.time, curve.nominal),
        Line("parameters only", "before", curve.time, curve.parameters_only),
        Line("augmented", "after", curve.time, curve.augmented),
    ]
    error = [
        Line("parameters only", "before", curve.time, curve.recorded - curve.parameters_only),
        Line("augmented", "after", curve.time, curve.recorded - curve.augmented),
    ]
    name = words(curve.signal)
    both = []
    for lines, what in ((signal, name), (error, f"{name} error (recorded less simulated)")):
        drawn = [line for line in lines if np.isfinite(line.y).any()]
        if not drawn:
            continue
        chart = line_chart(
            drawn,
            title=f"{what} in {curve.recording}",
            x_label="time [s]",
            y_label=_axis(what, curve.unit),
            windows=windows,
        )
        both.append(f"<figure>{legend(drawn)}{chart}</figure>")
    return "".join(both)


def _axis(what: str, unit: str) -> str:
    return f"{what} [{unit_words(unit)}]" if unit_words(unit) else what
