"""A recorded signal with its simulations: one chart of both, and below it what each leaves."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from gmfbo.pages.html_page import embedded_json
from gmfbo.pages.marked_number import unit_text
from gmfbo.pages.svg_chart import MOST_BUCKETS, Line, legend, line_chart
from gmfbo.pages.thinning import few_digits, thinned_rows

Array = NDArray[np.float64]

RECORDED = "recorded"

_MOST_POINTS = 48_000  # of all simulated lines: about half a megabyte
_MOST_NUMBERS = 110_000  # of all curves for the script: about another half megabyte


@dataclass(frozen=True, eq=False)
class SignalPanel:
    """One signal of one recording; n rows.

    Attributes
    ----------
    signal, recording, part : str
        Words for the signal, name of the recording, and its part, such as "fitted on".
    unit : str
        Of the signal, as the twin spells it.
    time : ndarray, shape (n,)
        [s] In the recording's own time.
    values : mapping of str to ndarray, shape (n,)
        [unit] `recorded`, and each model by its name; NaN where there is none.
    drawn, errors : tuple of str
        Names drawn as they are, in order, and models whose residual is drawn.
    styles, words : mapping of str to str
        By name: class in the page's style, and entry in the legend.
    windows : tuple of tuple of float
        [s] Stretches to shade.
    windows_mean : str
        What the shade means.
    """

    signal: str
    recording: str
    part: str
    unit: str
    time: Array
    values: Mapping[str, Array]
    drawn: tuple[str, ...]
    errors: tuple[str, ...]
    styles: Mapping[str, str]
    words: Mapping[str, str]
    windows: tuple[tuple[float, float], ...] = ()
    windows_mean: str = ""


def panel_figures(panels: Sequence[SignalPanel]) -> list[str]:
    """Draw panels, with fewer points each where there are many.

    Parameters
    ----------
    panels : sequence of SignalPanel
        In the order of the page.

    Returns
    -------
    list of str
        A `<figure>` for each, which the script of `panels.js` finds by its place.
    """
    buckets = max(30, min(MOST_BUCKETS, _MOST_POINTS // (10 * max(1, len(panels)))))
    return [_figure(place, panel, buckets) for place, panel in enumerate(panels)]


def panels_json(panels: Sequence[SignalPanel]) -> str:
    """Embed the curves for the script that reads values off them and zooms.

    Parameters
    ----------
    panels : sequence of SignalPanel
        As drawn by `panel_figures`.

    Returns
    -------
    str
        A `<script>` element with as many rows as a page of moderate size holds.
    """
    rows = _MOST_NUMBERS // (5 * max(1, len(panels)))
    told = [_content(panel, rows) for panel in panels]
    return embedded_json("curves", json.dumps(told, separators=(",", ":"), allow_nan=False))


def axis_words(what: str, unit: str) -> str:
    """Label of an axis: a quantity, with its unit in brackets where it has one.

    Parameters
    ----------
    what : str
        The quantity.
    unit : str
        As the twin spells it.
    """
    return f"{what} [{unit_text(unit)}]" if unit_text(unit) else what


def _figure(place: int, panel: SignalPanel, buckets: int) -> str:
    lines = [_line(panel, name) for name in panel.drawn]
    left = [_line(panel, name, error=True) for name in panel.errors]
    drawn = line_chart(
        lines,
        title=f"{panel.signal} in {panel.recording}",
        x_label="" if left else "time [s]",
        y_label=axis_words(panel.signal, panel.unit),
        windows=panel.windows,
        buckets=buckets,
    )
    if left:
        drawn += line_chart(
            left,
            title=f"{panel.signal} error in {panel.recording}",
            x_label="time [s]",
            y_label=axis_words("what is left: recorded less simulated", panel.unit),
            style="low",
            windows=panel.windows,
            buckets=buckets,
        )
    shaded = f'<span class="soft">; {panel.windows_mean}</span>' if panel.windows else ""
    name, recording = escape(panel.signal), escape(panel.recording)
    part = f", {escape(panel.part)}" if panel.part else ""
    return (
        f'<figure class="panel" data-curve="{place}" data-signal="{name}" '
        f'data-recording="{recording}" data-part="{escape(panel.part)}">'
        f"<figcaption><b>{name}</b> in {recording}{part}{shaded}</figcaption>"
        f"{legend(lines)}{drawn}</figure>"
    )


def _line(panel: SignalPanel, name: str, *, error: bool = False) -> Line:
    values = panel.values[name]
    y = panel.values[RECORDED] - values if error else values
    # What was measured keeps its shape, however many recordings share the page.
    return Line(panel.words[name], panel.styles[name], panel.time, y, whole=name == RECORDED)


def _content(panel: SignalPanel, most: int) -> dict[str, object]:
    shown = list(dict.fromkeys([*panel.drawn, *panel.errors]))
    recorded = panel.values[RECORDED]
    judged = [recorded, *(recorded - panel.values[name] for name in panel.errors)]
    if panel.time.size > most:
        rows = thinned_rows(judged, max(10, most // (2 * len(judged))))
    else:
        rows = np.arange(panel.time.size)
    return {
        "unit": unit_text(panel.unit),
        "signals": list(panel.drawn),
        "errors": list(panel.errors),
        "styles": {name: panel.styles[name] for name in shown},
        "words": {name: panel.words[name] for name in shown},
        "time": few_digits(panel.time[rows], 8),
        "values": {name: few_digits(panel.values[name][rows], 5) for name in shown},
    }
