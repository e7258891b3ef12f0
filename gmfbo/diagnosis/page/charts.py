"""Charts of a diagnosis: each recording before and after."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gmfbo.pages.signal_panel import SignalPanel, panel_figures, panels_json
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
    return panel_figures(_panels(diagnosis))


def curves_json(diagnosis: Findings) -> str:
    """Embed the curves for the script that reads values off them and zooms.

    Returns
    -------
    str
        A `<script>` element with as many rows as a page of moderate size holds.
    """
    return panels_json(_panels(diagnosis))


def _panels(diagnosis: Findings) -> list[SignalPanel]:
    return [_panel(diagnosis, curve) for curve in _ordered_curves(diagnosis)]


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


def _panel(diagnosis: Findings, curve: Curve) -> SignalPanel:
    signal, errors = _models(curve)
    return SignalPanel(
        signal=words(curve.signal),
        recording=curve.recording,
        part=part_words(diagnosis, curve.recording),
        unit=curve.unit,
        time=curve.time,
        values={name: getattr(curve, name) for name in {*signal, *errors}},
        drawn=tuple(signal),
        errors=tuple(errors),
        styles=STYLES,
        words=WORDS,
        windows=tuple(
            (window.start, window.end)
            for window in diagnosis.location.times
            if window.recording == curve.recording
        ),
        windows_mean="shaded: where the mismatch shows most",
    )
