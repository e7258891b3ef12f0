"""`report.html`: a diagnosis as one page that needs no network."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.plain_words import number, percent, unit_words, words
from gmfbo.reports.diagnosis_charts import before_and_after_charts, shape_chart
from gmfbo.reports.effect_account import effect_account
from gmfbo.reports.html_page import page, paragraph, section, table

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis

DIGITS = 4

_VERDICTS: Mapping[str, str] = {
    "none": "nothing beyond noise",
    "parameters": "the twin's uncertain values",
    "missing_physics": "missing physics",
    "outside_library": "physics outside the library",
}


def diagnosis_page(diagnosis: Diagnosis) -> str:
    """Write the page of a diagnosis.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.

    Returns
    -------
    str
        HTML with its style and drawings in it; every text of the diagnosis is escaped.
    """
    accounts = [effect_account(effect, diagnosis) for effect in diagnosis.effects]
    parts = [
        _head(diagnosis),
        section("Before and after", _fit_table(diagnosis), before_and_after_charts(diagnosis)),
        section("What is missing", *accounts),
        section("Shape of what has no name", _shape(diagnosis)),
        section("Where", *_where(diagnosis)),
        section("The twin's own values", *_values(diagnosis)),
        section("How the signals were logged", _alignment(diagnosis)),
        section("What would have shown", _detectable(diagnosis)),
        section("What could not be tested", _not_testable(diagnosis)),
        section("What to record next", *_next(diagnosis)),
        section("Remarks", *(paragraph(note) for note in diagnosis.notes)),
        section("This run", _run(diagnosis)),
    ]
    return page(f"Diagnosis: {_VERDICTS[diagnosis.verdict]}", "\n".join(filter(None, parts)))


def _head(diagnosis: Diagnosis) -> str:
    verdict = _VERDICTS[diagnosis.verdict]
    told = f"Verdict: {verdict}. Evidence: {diagnosis.evidence}."
    twin = diagnosis.augmentation.twin_name if diagnosis.augmentation else ""
    return (
        f'<header><p class="soft">{escape(f"Diagnosis of {twin}" if twin else "Diagnosis")}</p>'
        f"<h1>{escape(diagnosis.sentence)}</h1>{paragraph(told, 'soft')}</header>"
    )


def _fit_table(diagnosis: Diagnosis) -> str:
    fit = diagnosis.fit
    rows = [
        [
            words(name),
            percent(one.nominal),
            percent(one.parameters_only),
            percent(one.augmented),
            percent(one.noise_floor),
            percent(one.unnamed_spline),
        ]
        for name, one in fit.signals.items()
    ]
    heads = ["signal", "nominal", "parameters only", "augmented", "noise floor", "unnamed spline"]
    unseen, seen = ", ".join(fit.held_out) or "none", ", ".join(fit.fitted_on) or "none"
    told = (
        "RMS error over the range of the recorded signal: of the twin as it came (nominal), with "
        "its uncertain parameters refitted, and with the physics (augmented); the unnamed spline "
        "is a smooth residual without physics. On recordings that had no part in the fit: "
        f"{unseen}. Fitted on {seen}."
    )
    share = fit.explainable_error_removed
    removed = "" if share is None else f"Explainable error removed: {percent(share)}."
    drawn = table(heads, rows, numbers=range(1, 6))
    return paragraph(told) + drawn + paragraph(removed) if rows else ""


def _shape(diagnosis: Diagnosis) -> str:
    shape = diagnosis.shape
    if shape is None:
        return ""
    told = (
        f"No effect in the library has this shape at the {words(shape.port)} port; it was inferred "
        f"against the {words(shape.against)}."
    )
    return paragraph(told) + shape_chart(shape)


def _where(diagnosis: Diagnosis) -> list[str]:
    location = diagnosis.location
    path = f"In the {location.signal_path}" if location.signal_path else ""
    told = ", ".join(part for part in (path, location.region) if part)
    rows = [[name, number(start, 5), number(end, 5)] for name, start, end in location.times]
    return [
        paragraph(f"{told}." if told else ""),
        table(["recording", "from [s]", "to [s]"], rows, numbers=(1, 2)),
    ]


def _values(diagnosis: Diagnosis) -> list[str]:
    parameters = [
        [
            name,
            number(one.nominal, DIGITS),
            number(one.value, DIGITS),
            f"{number(one.low, DIGITS)} to {number(one.high, DIGITS)}",
            unit_words(one.unit),
            "yes" if one.identifiable else "only in a combination",
        ]
        for name, one in diagnosis.parameters.items()
    ]
    combined = [
        [
            one.expression,
            number(one.value, DIGITS),
            f"{number(one.low, DIGITS)} to {number(one.high, DIGITS)}",
        ]
        for one in diagnosis.combinations
    ]
    heads = ["parameter", "in the twin", "refitted", "95 % interval", "unit", "seen by itself"]
    return [
        table(heads, parameters, numbers=(1, 2, 3)),
        table(["combination", "value", "95 % interval"], combined, numbers=(1, 2)),
    ]


def _alignment(diagnosis: Diagnosis) -> str:
    rows = [
        [
            words(name),
            one.logged,
            number(one.shift, DIGITS),
            number(one.scale, DIGITS),
            number(one.offset, DIGITS),
        ]
        for name, one in diagnosis.alignment.items()
    ]
    heads = ["signal", "command logged", "late by [s]", "scale", "offset"]
    return table(heads, rows, numbers=(2, 3, 4))


def _detectable(diagnosis: Diagnosis) -> str:
    rows = [
        [words(name), words(one.parameter), number(one.size, DIGITS), unit_words(one.unit)]
        for name, one in diagnosis.detectable.items()
    ]
    if not rows:
        return ""
    told = paragraph("Effects that were not named, and the smallest size that would have been.")
    return told + table(["effect", "measured by", "smallest", "unit"], rows, numbers=(2,))


def _not_testable(diagnosis: Diagnosis) -> str:
    rows = [[words(one.name), one.why] for one in diagnosis.not_testable]
    return table(["effect", "why"], rows)


def _next(diagnosis: Diagnosis) -> list[str]:
    planned = diagnosis.next_experiment
    if planned is None:
        return []
    apart = " from ".join(words(name) for name in planned.separates)
    enough = "enough" if planned.distance >= planned.threshold else "not enough"
    told = f"Play {planned.reference}: {planned.why.rstrip('.')}."
    if apart:
        told += (
            f" It tells {apart}: predicted distance {number(planned.distance, DIGITS)}, threshold "
            f"{number(planned.threshold, DIGITS)}, {enough} to decide."
        )
    rows = [[words(name), outcome] for name, outcome in planned.predicted.items()]
    return [paragraph(told), table(["if it is", "then"], rows)]


def _run(diagnosis: Diagnosis) -> str:
    cost = diagnosis.cost
    versions = ", ".join(f"{name} {version}" for name, version in diagnosis.versions.items())
    told = (
        f"{cost.simulations} simulations in {number(cost.seconds, DIGITS)} s, seed "
        f"{diagnosis.seed}; {versions}."
    )
    return paragraph(told, "facts")
