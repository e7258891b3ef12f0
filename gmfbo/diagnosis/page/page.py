"""`report.html`: a diagnosis as one page that needs no network."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.charts import curves_json
from gmfbo.diagnosis.page.effect_account import effect_account
from gmfbo.diagnosis.page.first_screen import first_screen, place_words, verdict_words
from gmfbo.diagnosis.page.limits_account import detectable_sizes, residual_tests, untested_effects
from gmfbo.diagnosis.page.loop_drawing import loop_drawing
from gmfbo.diagnosis.page.shape_chart import inferred_shape
from gmfbo.diagnosis.page.time_line import time_line
from gmfbo.diagnosis.page.twin_account import alignment_table, combination_table, parameter_table
from gmfbo.diagnosis.result.cautions import cautions
from gmfbo.diagnosis.result.certainty import is_sure, label
from gmfbo.diagnosis.result.diagnosis_json import diagnosis_text
from gmfbo.pages.html_page import columns, embedded_json, page, page_file, paragraph, section, table
from gmfbo.pages.marked_number import marked_count, marked_number
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings


def diagnosis_page(diagnosis: Findings) -> str:
    """Write the page of a diagnosis.

    Parameters
    ----------
    diagnosis : Findings
        Result of the diagnosis.

    Returns
    -------
    str
        HTML with its style, drawings and `diagnosis.json` in it; every text of the diagnosis is
        escaped, every number marked with its place in the JSON.
    """
    accounts = [effect_account(place, diagnosis) for place in range(len(diagnosis.effects))]
    parts = [
        first_screen(diagnosis),
        section("Where", *_where(diagnosis), name="where"),
        section(_missing_head(diagnosis), *accounts, name="missing"),
        section(
            "The twin's own values",
            *(paragraph(caution) for caution in cautions(diagnosis)),
            columns(parameter_table(diagnosis), combination_table(diagnosis)),
        ),
        section("How the signals were logged", alignment_table(diagnosis)),
        section("Does what is left still follow the reference?", residual_tests(diagnosis)),
        section("What to record next", *_next(diagnosis), name="next"),
        section("What could not be tested", untested_effects(diagnosis)),
        section("Looked for, and not found", detectable_sizes(diagnosis), name="shown"),
        section("Remarks", *(paragraph(note) for note in diagnosis.notes)),
        _data(diagnosis),
        _footer(diagnosis),
        embedded_json("diagnosis", diagnosis_text(diagnosis)),
        curves_json(diagnosis),
    ]
    return page(
        f"Diagnosis: {verdict_words(diagnosis)}",
        "\n".join(filter(None, parts)),
        styles=(page_file("style.css"),),
        scripts=(page_file("charts.js"), page_file("panels.js")),
    )


def _missing_head(diagnosis: Findings) -> str:
    sure = any(is_sure(effect.set_probability) for effect in diagnosis.effects)
    return "What is missing" if sure else "What may be missing"


def _where(diagnosis: Findings) -> list[str]:
    told = place_words(diagnosis)
    if not told and diagnosis.shape is None and not diagnosis.location.times:
        return []
    guilty = dict.fromkeys(filter(None, [diagnosis.location.signal_path]))
    labels: dict[str, list[str]] = {}
    for effect in diagnosis.effects:
        known = CATALOGUE.get(effect.name)
        if known is not None:
            guilty.setdefault(known.signal_path)
            labels.setdefault(known.signal_path, []).append(label(effect))
    drawing = loop_drawing(list(guilty), {part: names[:2] for part, names in labels.items()})
    sentence = f"{told[0].upper()}{told[1:]}." if told else ""
    return [columns(paragraph(sentence) + drawing, inferred_shape(diagnosis)), time_line(diagnosis)]


def _next(diagnosis: Findings) -> list[str]:
    planned = diagnosis.next_experiment
    if planned is None:
        return []
    play = f"Play <b>{escape(planned.reference)}</b>" if planned.reference else "Record more"
    told = f"<p>{play}: {escape(planned.why.rstrip('.'))}.</p>"
    if planned.separates and planned.threshold > 0.0:
        enough = "enough" if planned.distance >= planned.threshold else "not enough"
        distance = marked_number(("next_experiment", "distance"), planned.distance)
        threshold = marked_number(("next_experiment", "threshold"), planned.threshold)
        told += (
            f"<p>Log odds of at least {distance} nats are expected for the true one; {threshold} "
            f"would do, so it is {enough} to decide.</p>"
        )
    rows = [[escape(words(name)), escape(what)] for name, what in planned.predicted.items()]
    return [told, table(["if it is", "then"], rows) if rows else ""]


def _data(diagnosis: Findings) -> str:
    unseen = ", ".join(diagnosis.fit.held_out) or "none"
    seen = ", ".join(diagnosis.fit.fitted_on) or "none"
    return section(
        "What the errors are",
        paragraph(
            "Errors are of recordings that had no part in the fit, by parameters fitted on the "
            f"others. Unseen: {unseen}. Fitted on: {seen}."
        ),
        paragraph(
            "Twin as it came: with the values in its file. Parameters only: its uncertain values "
            "refitted. Augmented twin: with what is named here, and refitted. Unnamed spline: "
            "a smooth correction without physics, for comparison. Noise floor: what a perfect twin "
            "would leave."
        ),
    )


def _footer(diagnosis: Findings) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in diagnosis.versions.items())
    simulations = marked_count(("cost", "simulations"), diagnosis.cost.simulations)
    seconds = marked_number(("cost", "seconds"), diagnosis.cost.seconds)
    seed = marked_count(("seed",), diagnosis.seed)
    return (
        f"<footer><p>{simulations} simulations in {seconds}\u00a0s, seed {seed}. "
        f"{escape(versions)}.</p>{_stages(diagnosis)}<p class=soft>All numbers on this page are "
        "those of diagnosis.json, which is also inside this file.</p></footer>"
    )


def _stages(diagnosis: Findings) -> str:
    shown = [
        f"{escape(stage)} {marked_number(('cost', 'stages', stage), seconds)}\u00a0s"
        for stage, seconds in diagnosis.cost.stages.items()
    ]
    return f"<p>By stage: {', '.join(shown)}.</p>" if shown else ""
