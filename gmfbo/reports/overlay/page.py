"""Recorded and simulated trajectories on one page that needs no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

from gmfbo.objective.fit import compare_at
from gmfbo.pages.html_page import columns, page, page_file, paragraph, section
from gmfbo.pages.marked_number import unit_text
from gmfbo.pages.svg_chart import Line, legend, line_chart
from gmfbo.plain_words import percent, words
from gmfbo.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Overlay:
    """A recording and a simulation along it.

    Attributes
    ----------
    recording, run : Recording
        Measured and simulated, in SI.
    errors : mapping of str to float
        NRMSE by compared signal [1]; these are drawn.
    remarks : sequence of str
        What is to be known of this recording, a line each.
    """

    recording: Recording
    run: Recording
    errors: Mapping[str, float]
    remarks: Sequence[str] = ()


def overlay_page(title: str, story: str, overlays: Sequence[Overlay]) -> str:
    """Draw each compared signal of each recording over the simulation, and their difference.

    Parameters
    ----------
    title : str
        Heading.
    story : str
        One paragraph below it.
    overlays : sequence of Overlay
        Recordings, in the order of the page.

    Returns
    -------
    str
        HTML; every text is escaped.
    """
    parts = [f"<h1>{escape(title)}</h1>", paragraph(story, "lead")]
    for overlay in overlays:
        figures = [_figure(overlay, name) for name in overlay.errors]
        remarks = [paragraph(remark) for remark in overlay.remarks]
        parts.append(section(overlay.recording.name or "recording", *remarks, columns(*figures)))
    return page(title, "\n".join(parts), styles=(page_file("style.css"),), scripts=())


def _figure(overlay: Overlay, name: str) -> str:
    recorded, run = overlay.recording, overlay.run
    unit = unit_text(run.units.get(name, "") or recorded.units.get(name, ""))
    lines = [
        Line("recorded", "recorded", recorded.time, recorded.signal(name)),
        Line("simulated", "after", run.time, run.signal(name)),
    ]
    left = [Line("recorded - simulated", "before", recorded.time, compare_at(run, recorded, name))]
    inside = f" [{unit}]" if unit else ""
    signal = line_chart(
        lines, title=f"{words(name)} over time", x_label="", y_label=f"{words(name)}{inside}"
    )
    error = line_chart(
        left,
        title=f"error of {words(name)} over time",
        x_label="time [s]",
        y_label=f"recorded - simulated{inside}",
        style="low",
    )
    caption = f"{words(name)}: error {percent(overlay.errors[name])} (RMS over range)"
    return (
        f"<figure><figcaption>{escape(caption)}</figcaption>{legend(lines)}{signal}{error}</figure>"
    )
