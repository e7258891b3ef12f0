"""Charts of a diagnosis: each recording before and after."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.pages.html_page import embedded_json
from gmfbo.pages.marked_number import unit_text
from gmfbo.pages.svg_chart import MOST_BUCKETS, Line, legend, line_chart
from gmfbo.pages.thinning import few_digits, thinned_rows
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.curve import Curve
    from gmfbo.diagnosis.result.findings import Findings

STYLES: Mapping[str, str] = {
    "recorded": "recorded",
    "nominal": "nominal",
    "parameters_only": "before",
    "augmented": "after",
}
"""Class in the page's style of each model's curve."""

WORDS: Mapping[str, str] = {
    "recorded": "recorded",
    "nominal": "twin as it came",
    "parameters_only": "parameters only",
    "augmented": "augmented twin",
    "unnamed_spline": "unnamed spline",
    "noise_floor": "noise floor",
}
"""Name of each model on the page."""

_MOST_POINTS = 48_000  # of all simulated lines: about half a megabyte
_MOST_NUMBERS = 110_000  # of all curves for the script: about another half megabyte


def recordings_to_show(diagnosis: Findings) -> list[str]:
    """Recordings that have curves: held-out ones first, by improvement.

    Returns
    -------
    list of str
        Their names.
    """
    names = list(dict.fromkeys(curve.recording for curve in diagnosis.curves))
    gains = diagnosis.effects[0].evidence_per_recording if diagnosis.effects else {}
    held_out = set(diagnosis.fit.held_out)
    return sorted(names, key=lambda name: (name not in held_out, -gains.get(name, 0.0)))


def _ordered_curves(diagnosis: Findings) -> list[Curve]:
    """Return the curves as they are shown: the signal that improves most comes first."""
    fit = diagnosis.fit.signals
    best = diagnosis.fit.most_improved
    if best is None and fit:
        best = max(fit, key=lambda name: float(np.nan_to_num(fit[name].parameters_only)))
    return [
        curve
        for name in recordings_to_show(diagnosis)
        for curve in sorted(diagnosis.curves, key=lambda c: c.signal != best)
        if curve.recording == name
    ]


def before_and_after_panels(diagnosis: Findings) -> list[str]:
    """Draw each signal of each recording, and below it the errors of the models.

    Parameters
    ----------
    diagnosis : Findings
        Result of the diagnosis; without curves there is nothing to draw.

    Returns
    -------
    list of str
        A `<figure>` for each, the most telling first.
    """
    curves = _ordered_curves(diagnosis)
    buckets = max(30, min(MOST_BUCKETS, _MOST_POINTS // (10 * max(1, len(curves)))))
    return [_panel(diagnosis, place, curve, buckets) for place, curve in enumerate(curves)]


def curves_json(diagnosis: Findings) -> str:
    """Embed the curves for the script that reads values off them and zooms.

    Returns
    -------
    str
        A `<script>` element with as many rows as a page of moderate size holds.
    """
    curves = _ordered_curves(diagnosis)
    rows = _MOST_NUMBERS // (5 * max(1, len(curves)))
    told = [_content(curve, rows) for curve in curves]
    return embedded_json("curves", json.dumps(told, separators=(",", ":"), allow_nan=False))


def axis_words(what: str, unit: str) -> str:
    """Label of an axis: a quantity and its unit, if it has one."""
    return f"{what} [{unit_text(unit)}]" if unit_text(unit) else what


def part_words(diagnosis: Findings, recording: str) -> str:
    """Words that say whether a recording had a part in the fit."""
    return "unseen by the fit" if recording in diagnosis.fit.held_out else "fitted on"


def _models(curve: Curve) -> tuple[list[str], list[str]]:
    """Lines of the signal and of its error; later ones are drawn on top."""
    known = [name for name in STYLES if np.isfinite(getattr(curve, name)).any()]
    signal = ["recorded", "parameters_only", "augmented"]
    errors = ["parameters_only", "augmented"]
    if "augmented" not in known:
        signal, errors = ["recorded", "nominal", "parameters_only"], ["nominal", "parameters_only"]
    return [n for n in signal if n in known], [n for n in errors if n in known]


def _panel(diagnosis: Findings, place: int, curve: Curve, buckets: int) -> str:
    windows = [
        (window.start, window.end)
        for window in diagnosis.location.times
        if window.recording == curve.recording
    ]
    name, part = words(curve.signal), part_words(diagnosis, curve.recording)
    signal, errors = _models(curve)
    lines = [_line(curve, model) for model in signal]
    left = [_line(curve, model, error=True) for model in errors]
    drawn = line_chart(
        lines,
        title=f"{name} in {curve.recording}",
        x_label="" if left else "time [s]",
        y_label=axis_words(name, curve.unit),
        windows=windows,
        buckets=buckets,
    )
    if left:
        drawn += line_chart(
            left,
            title=f"{name} error in {curve.recording}",
            x_label="time [s]",
            y_label=axis_words("what is left: recorded less simulated", curve.unit),
            style="low",
            windows=windows,
            buckets=buckets,
        )
    shaded = '<span class="soft">; shaded: where the mismatch shows most</span>' if windows else ""
    caption = f"<b>{escape(name)}</b> in {escape(curve.recording)}, {part}{shaded}"
    return (
        f'<figure class="panel" data-curve="{place}" data-signal="{escape(name)}" '
        f'data-recording="{escape(curve.recording)}" data-part="{part}">'
        f"<figcaption>{caption}</figcaption>{legend(lines)}{drawn}</figure>"
    )


def _line(curve: Curve, model: str, *, error: bool = False) -> Line:
    values: NDArray[np.float64] = getattr(curve, model)
    y = curve.recorded - values if error else values
    # What was measured keeps its shape, however many recordings share the page.
    return Line(WORDS[model], STYLES[model], curve.time, y, whole=model == "recorded")


def _content(curve: Curve, most: int) -> dict[str, object]:
    signal, errors = _models(curve)
    shown = list(dict.fromkeys([*signal, *errors]))
    judged = [curve.recorded, *(curve.recorded - getattr(curve, name) for name in errors)]
    if curve.time.size > most:
        rows = thinned_rows(judged, max(10, most // (2 * len(judged))))
    else:
        rows = np.arange(curve.time.size)
    return {
        "unit": unit_text(curve.unit),
        "signals": signal,
        "errors": errors,
        "styles": {name: STYLES[name] for name in shown},
        "words": {name: WORDS[name] for name in shown},
        "time": few_digits(curve.time[rows], 8),
        "values": {name: few_digits(getattr(curve, name)[rows], 5) for name in shown},
    }
