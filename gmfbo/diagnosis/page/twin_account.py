"""The twin's own values after the refit, and how its signals were logged."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.result.misaligned_columns import misaligned_sentence
from gmfbo.pages.html_page import paragraph, table
from gmfbo.pages.marked_number import (
    marked,
    marked_interval,
    marked_number,
    scale_for,
)
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import Alignment
    from gmfbo.diagnosis.result.findings import Findings

_LOGGED = {"held": "the one still in force", "new": "the one just computed"}
"""What a controller logs beside a measurement: the command before or after its computation."""


def parameter_table(diagnosis: Findings) -> str:
    """Show each uncertain parameter before and after the refit."""
    rows = []
    for name, one in diagnosis.parameters.items():
        path = ("parameters", name)
        shown = marked_interval(path, one.value, one.low, one.high, one.unit)
        ends = [abs(x) for x in (one.value, one.low, one.high) if x == x]
        factor = scale_for(max(ends, default=0.0), one.unit).factor
        nominal = marked_number((*path, "nominal"), one.nominal, factor=factor, digits=4)
        # An unidentifiable parameter keeps its value, and its interval says nothing.
        interval = f"{shown.low} to {shown.high}" if one.identifiable else "not seen by itself"
        unit = f'<span class="nowrap">{escape(shown.unit)}</span>'
        value = shown.value if one.identifiable else nominal
        if one.at_bound is not None:
            end = marked_number((*path, "bound"), one.bound, factor=factor, digits=4)
            interval += f" (its range ends at {end})"
        rows.append([escape(f"{name}{one.where_fixed}"), nominal, value, interval, unit])
    heads = ["parameter", "in the twin", "refitted", "95 % interval", "unit"]
    return table(heads, rows, numbers=(1, 2, 3)) + _drifts(diagnosis)


def _drifts(diagnosis: Findings) -> str:
    """Values of parameters that differ from recording to recording."""
    told = []
    for name, one in diagnosis.parameters.items():
        if one.drifts:
            factor = scale_for(max(abs(v) for v in one.drifts.values()), one.unit).factor
            rows = [
                [
                    escape(recording),
                    marked_number(("parameters", name, "drifts", recording), value, factor=factor),
                ]
                for recording, value in one.drifts.items()
            ]
            told.append(table([f"{escape(name)} in", "value"], rows, numbers=(1,)))
    return "".join(told)


def combination_table(diagnosis: Findings) -> str:
    """Show identifiable combinations of parameters that are not identifiable alone."""
    rows = []
    for place, one in enumerate(diagnosis.combinations):
        shown = marked_interval(("combinations", place), one.value, one.low, one.high, "")
        rows.append([escape(one.expression), shown.value, f"{shown.low} to {shown.high}"])
    if not rows:
        hidden = [name for name, one in diagnosis.parameters.items() if not one.identifiable]
        told = "Each parameter is seen by itself." if diagnosis.parameters and not hidden else ""
        return paragraph(told, "soft")
    told = "Some parameters are not visible by themselves in these recordings, only together:"
    return paragraph(told) + table(["combination", "value", "95 % interval"], rows, numbers=(1, 2))


def alignment_table(diagnosis: Findings) -> str:
    """Show how each signal was logged."""
    units = {curve.signal: curve.unit for curve in diagnosis.curves}
    rows = [
        [
            escape(words(name)),
            escape(_LOGGED.get(one.logged, one.logged)),
            _lateness(name, one),
            marked(("alignment", name, "scale"), f"{one.scale:.4f}"),
            _offset(name, one, units.get(name, "")),
            _beyond(name, one),
            escape(words(one.rival)) if one.rival else "",
        ]
        for name, one in diagnosis.alignment.items()
    ]
    told = "Found beside the physics, and never taken for physics."
    heads = [
        *("signal", "the command in each row is", "column is", "scale", "offset"),
        *("more than usual, in standard deviations", "or else"),
    ]
    listed = table(heads, rows, numbers=(2, 3, 4)) if rows else ""
    either = paragraph(misaligned_sentence(diagnosis))
    return paragraph(told, "soft") + either + listed if rows else ""


def _beyond(name: str, one: Alignment) -> str:
    """Kinds of which a column has more than its prior allows."""
    return ", ".join(
        f"{kind} {marked_number(('alignment', name, 'beyond_prior', kind), deviations)}"
        for kind, deviations in one.beyond_prior.items()
    )


def _lateness(name: str, one: Alignment) -> str:
    """Delay of a column in words; a negative delay is called early."""
    path = ("alignment", name, "shift")
    scale = scale_for(one.shift, "s")
    if one.shift == 0.0:
        return f"{marked(path, '0')}\u00a0s late"
    word, sign = ("late", 1.0) if one.shift > 0.0 else ("early", -1.0)
    shown = marked_number(path, one.shift, factor=sign * scale.factor, digits=2)
    return f"{shown}\u00a0{scale.unit} {word}"


def _offset(name: str, one: Alignment, unit: str) -> str:
    scale = scale_for(one.offset, unit)
    shown = marked_number(("alignment", name, "offset"), one.offset, factor=scale.factor, digits=2)
    return f"{shown}\u00a0{escape(scale.unit)}" if scale.unit else shown
