"""Recordings over time, with the stretches in which the mismatch shows most."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.charts import part_words
from gmfbo.pages.html_page import folded, paragraph, table
from gmfbo.pages.marked_number import marked_number

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings

_DIGITS = 6  # a time of minutes to the millisecond


def time_line(diagnosis: Findings) -> str:
    """Draw each recording as a bar on one common scale, its marked stretches upon it.

    Parameters
    ----------
    diagnosis : Findings
        Result of the diagnosis; without marked times there is nothing to draw.

    Returns
    -------
    str
        HTML, with the times as numbers folded below it.
    """
    location = diagnosis.location
    if not location.times:
        return ""
    spans = _spans(diagnosis)
    longest = max(end - start for start, end in spans.values()) or 1.0
    rows = []
    for name, (start, end) in spans.items():
        held_out = name in diagnosis.fit.held_out
        marks = "".join(
            f'<rect class="mark" x="{100.0 * (window.start - start) / longest:.3f}%" y="2" '
            f'width="{max(100.0 * (window.end - window.start) / longest, 0.4):.3f}%" height="14"/>'
            for window in location.times
            if window.recording == name
        )
        wide = 100.0 * (end - start) / longest
        kind = "name held-out" if held_out else "name"
        rows.append(
            f'<span class="{kind}">{escape(name)}</span>'
            f'<svg role="img" aria-label="{escape(f"{name}, {part_words(diagnosis, name)}")}">'
            f'<rect class="bar" x="0" y="2" width="{wide:.3f}%" height="14"/>{marks}</svg>'
        )
    numbers = [
        [
            escape(window.recording),
            marked_number(("location", "times", place, 1), window.start, digits=_DIGITS),
            marked_number(("location", "times", place, 2), window.end, digits=_DIGITS),
        ]
        for place, window in enumerate(location.times)
    ]
    told = paragraph("When it shows most; recordings in bold are unseen by the fit.", "soft small")
    listed = table(["recording", "from [s]", "to [s]"], numbers, numbers=(1, 2))
    return f'{told}<div class="times">{"".join(rows)}</div>{folded("Times as numbers", listed)}'


def _spans(diagnosis: Findings) -> dict[str, tuple[float, float]]:
    """Begin and end [s] of each recording, or of its marked stretches where it has no curves."""
    spans: dict[str, tuple[float, float]] = {}
    for curve in diagnosis.curves:
        begin, end = float(curve.time[0]), float(curve.time[-1])
        low, high = spans.get(curve.recording, (begin, end))
        spans[curve.recording] = (min(low, begin), max(high, end))
    for window in diagnosis.location.times:
        low, high = spans.get(window.recording, (window.start, window.end))
        spans[window.recording] = (min(low, window.start), max(high, window.end))
    return spans
