"""Limits of a diagnosis: untested effects, smallest detectable sizes, residual tests."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.pages.html_page import columns, paragraph, table
from gmfbo.pages.marked_number import marked_number, marked_percent, scale_for
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import NOT_EXCITED, words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings

_PARTS = ("plant", "transmission", "actuator", "sensor", "controller")
_UNSEEN = "The motion does not show it"
_PARAMETER = "A refitted parameter does the same"
_TWIN = "The twin does not offer it"

_MEASURES = {
    "level": "largest value",
    "breakaway": "extra force before it moves",
    "cut": "largest part of the command that is cut off",
    "lag": "largest delay behind the command",
    "loss": "largest share that is lost",
    "windup": "twist under the largest load",
    "width": "width of the zone without response",
    "share": "error as a share of the reading",
    "time": "time constant",
}
"""What the size of an effect is, where its name alone does not say it."""


def untested_effects(diagnosis: Findings) -> str:
    """List the effects that could not be tested, by reason."""
    groups: dict[str, dict[str, list[str]]] = {}
    for one in diagnosis.not_testable:
        kind, why = _kind(one.why)
        groups.setdefault(kind, {}).setdefault(why, []).append(words(one.name))
    parts = []
    for kind in (_UNSEEN, _PARAMETER, _TWIN):
        reasons = groups.get(kind, {})
        rows = [[escape(", ".join(names)), escape(why)] for why, names in reasons.items()]
        if rows:
            listed = table(["effects", "why"], rows).replace("<table", '<table class="reasons"')
            parts.append(f"<h3>{kind}</h3>{listed}")
    return "".join(parts)


def _kind(why: str) -> tuple[str, str]:
    if why.startswith(NOT_EXCITED):
        return _UNSEEN, why.removeprefix(NOT_EXCITED).lstrip(": ") or why
    if why.startswith("changes nothing"):
        return _UNSEEN, why
    if why.startswith("is parameter "):
        return _PARAMETER, why
    return _TWIN, why


def detectable_sizes(diagnosis: Findings) -> str:
    """List the smallest size of each effect that would have been named, by part of the loop."""
    if not diagnosis.detectable:
        return ""
    parts: dict[str, list[list[str]]] = {}
    for name, one in diagnosis.detectable.items():
        known = CATALOGUE.get(name)
        scale = scale_for(one.size, one.unit, share=True)
        path = ("detectable", name, one.parameter)
        size = marked_number(path, one.size, factor=scale.factor, digits=2)
        unit = f"\u00a0{escape(scale.unit)}" if scale.unit else ""
        measure = _MEASURES.get(one.parameter, words(one.parameter))
        row = [escape(words(name)), escape(measure), f"{size}{unit}"]
        parts.setdefault(known.signal_path if known else "", []).append(row)
    told = paragraph(
        "Each of these effects would have been named if it were larger than the size given here. "
        "These recordings do not show a smaller one."
    )
    known_parts = [part for part in _PARTS if part in parts]
    drawn = [
        f"<h3>{escape(part.capitalize() or 'Elsewhere')}</h3>"
        + table(["effect", "its size is the", "named from"], parts[part], numbers=(2,))
        for part in (*known_parts, *(part for part in parts if part not in _PARTS))
    ]
    return told + columns(*drawn)


def residual_tests(diagnosis: Findings) -> str:
    """Show how much of each model's residual still follows the reference."""
    rows = []
    for place, one in enumerate(diagnosis.residual_tests):
        own = ("residual_tests", place)
        if one.follows <= one.bound:
            verdict = "no"
        else:
            verdict = "within tolerance" if one.follows <= one.tolerance else "yes"
        rows.append(
            [
                f"{escape(words(one.signal))} in {escape(one.recording)}",
                marked_percent((*own, "before"), one.before),
                marked_percent((*own, "follows"), one.follows),
                marked_percent((*own, "bound"), one.bound),
                marked_percent((*own, "tolerance"), one.tolerance),
                verdict,
            ]
        )
    told = (
        "Part of the error that is linear in the reference, its rate and its acceleration, or "
        "turns with its direction, in per cent of the signal's range. A twin that lacks nothing "
        "leaves no more than chance does."
    )
    heads = ["signal", "parameters only", "final model", "by chance", "tolerance", "follows"]
    return paragraph(told) + table(heads, rows, numbers=(1, 2, 3, 4)) if rows else ""
