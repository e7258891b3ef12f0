"""Marks of runs in a chart: a shape and colour for each source, of fixed size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gmfbo.pages.svg_axis import Axis
from gmfbo.pages.svg_frame import HIGH, WIDE
from gmfbo.reports.study.run_roles import Run

_SHAPES: Mapping[str, str] = {
    "IS1": "M-5.5 0a5.5 5.5 0 1 0 11 0a5.5 5.5 0 1 0-11 0",
    "IS2": "M-2.2-2.2h4.4v4.4h-4.4Z",
    "IS3": "M0-4L3.6 2.6H-3.6Z",
    "best": "M0-10L2.4-3.3 9.5-3.1 3.9 1.3 5.9 8.1 0 4.1-5.9 8.1-3.9 1.3-9.5-3.1-2.4-3.3Z",
}

SOURCES: Mapping[str, str] = {
    "IS1": "real axis (IS1)",
    "IS2": "twin (IS2)",
    "IS3": "corrected twin (IS3)",
}
"""Name of each source."""


def run_mark(run: Run, x: float, y: float, x_axis: Axis, y_axis: Axis, style: str = "") -> str:
    """Draw a run, which a script may make selectable."""
    ended = "" if run.trial.status == "ok" else "early"
    kind = " ".join(filter(None, ["mark", run.trial.source, run.role, ended, style]))
    place = f'x="{_share(x_axis, x, WIDE)}%" y="{_share(y_axis, y, HIGH)}%"'
    return (
        f'<svg class="{kind}" {place} data-run="{run.trial.number}">'
        f'<path d="{_SHAPES[run.trial.source]}"/></svg>'
    )


def best_mark(run: Run, x: float, y: float, x_axis: Axis, y_axis: Axis) -> str:
    """Draw the best run as a star."""
    place = f'x="{_share(x_axis, x, WIDE)}%" y="{_share(y_axis, y, HIGH)}%"'
    return (
        f'<svg class="mark best" {place} data-run="{run.trial.number}">'
        f'<path d="{_SHAPES["best"]}"/></svg>'
    )


def mark_legend(kinds: Sequence[tuple[str, str]]) -> str:
    """Name marks beside one of them, as an HTML list.

    Parameters
    ----------
    kinds : sequence of (str, str)
        Of each its kind, a source or `best`, and its name.
    """
    entries = "".join(
        '<li><svg class="swatch" viewBox="0 0 26 10" aria-hidden="true">'
        f'<svg class="mark {kind}" x="13" y="5"><path d="{_SHAPES[kind]}"/></svg></svg>'
        f"{name}</li>"
        for kind, name in kinds
    )
    return f'<ul class="legend">{entries}</ul>'


def _share(axis: Axis, value: float, length: float) -> str:
    return f"{100.0 * float(axis.at(value)) / length:.2f}"
