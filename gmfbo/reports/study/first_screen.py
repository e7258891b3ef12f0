"""First screen of a study: best gains, their improvement on the first run, and the cost."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from gmfbo.pages.html_page import paragraph, table
from gmfbo.pages.marked_number import (
    marked,
    marked_count,
    marked_number,
    unit_text,
)
from gmfbo.pages.svg_chart import Line, legend, line_chart
from gmfbo.plain_words import number, percent, words
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.metric_cells import metric_cell, metric_head
from gmfbo.reports.study.review import StudyReview
from gmfbo.reports.study.study_remarks import limits_missed
from gmfbo.tuning.history.incumbent import none_settled, runs_at

NO_BREAK = "\u00a0"


def study_first_screen(review: StudyReview, content: Mapping[str, Any]) -> str:
    """Write the part of the page that shows before scrolling.

    Parameters
    ----------
    review : StudyReview
        The study as it is shown.
    content : mapping
        Of `study_content`.
    """
    panel = responses_panel(review)
    numbers = f'<div class="numbers">{_comparison(review, content)}{_facts(review, content)}</div>'
    layout = "first" if panel else "first alone"
    return f'{_head(review, content)}<div class="{layout}">{panel}{numbers}</div>'


def _gains_html(path: tuple[str | int, ...], gains: Mapping[str, float]) -> str:
    return ", ".join(
        f'<span class="nowrap">{escape(name)} = {marked_number((*path, name), value, digits=4)}'
        "</span>"
        for name, value in gains.items()
    )


def _run_place(review: StudyReview, trial: Trial) -> int:
    return next(k for k, run in enumerate(review.runs) if run.trial is trial)


def _head(review: StudyReview, content: Mapping[str, Any]) -> str:
    file, best = review.file, review.best
    state, style = _state(review)
    seed = marked_count(("seed",), file.seed)
    top = (
        f'<div class="top"><span>Tuning of <b>{escape(file.name)}</b></span>'
        f'<span class="badge {style}">{state}</span>'
        f"<span>method {escape(file.method)}, seed {seed}</span></div>"
    )
    real = marked_count(("counts", "IS1"), content["counts"]["IS1"])
    if best is None:
        headline = f"None of {real} real runs succeeded, so there are no gains to take"
        return f'<header>{top}<h1 id="verdict">{headline}</h1></header>'
    gains = _gains_html(("runs", _run_place(review, best), "gains"), best.gains)
    found = marked_count(("best_real_run",), content["best_real_run"])
    if review.settled:
        headline = f"Best gains: {gains}, found at real run {found} of {real}"
    elif review.ended:
        told = none_settled(real)
        headline = f"{told[0].upper()}{told[1:]}. Least bad: {gains}, at real run {found}"
    else:
        headline = f"No real run of {real} has settled yet. Least bad so far: {gains}"
    return f'<header>{top}<h1 id="verdict">{headline}</h1>{_lead(review, content)}</header>'


def _lead(review: StudyReview, content: Mapping[str, Any]) -> str:
    counts, parts = content["counts"], []
    for source, what in (("IS2", "of the twin"), ("IS3", "of the corrected twin")):
        if counts[source]:
            parts.append(f"{marked_count(('counts', source), counts[source])} {what}")
    real = marked_count(("counts", "IS1"), counts["IS1"])
    simulated = marked_count(("simulated",), content["simulated"])
    which = f" ({', '.join(parts)})" if len(parts) > 1 else ""
    missed = limits_missed(review)
    limits = f" <b>{missed}</b>" if missed else ""
    return f'<p class="lead">{real} real runs, {simulated} simulated{which}.{limits}</p>'


def _state(review: StudyReview) -> tuple[str, str]:
    state = "ended" if review.ended else "not ended"
    if review.best is None:
        return f"{state}, no gains", "missing_physics"
    if not review.settled:
        return f"{state}, none settled", "missing_physics"
    return state, "none" if review.ended else "parameters"


def _comparison(review: StudyReview, content: Mapping[str, Any]) -> str:
    compared = content["comparison"]
    rows = []
    for name, one in compared.items():
        path = ("comparison", name)
        label = "objective g" if name == "objective" else metric_head(review, name)
        first, best = (np.nan if one[which] is None else one[which] for which in ("first", "best"))
        rows.append(
            [
                escape(label),
                metric_cell(review, name, (*path, "first"), first),
                metric_cell(review, name, (*path, "best"), best),
                _change((*path, "change"), one["change"]),
            ]
        )
    heads = ["", "first real run", f"{review.best_words} real run", "change"]
    return table(heads, rows, numbers=(1, 2, 3), style="wide errors")


def _change(path: tuple[str, ...], share: float | None) -> str:
    if share is None:
        return marked(path, "-")
    text = percent(share).removesuffix(" %")
    return marked(path, text, factor=0.01) + f"{NO_BREAK}%"


def _facts(review: StudyReview, content: Mapping[str, Any]) -> str:
    facts = []
    advised = content["recommendation"]
    if advised is not None:
        gains = _gains_html(("recommendation", "gains"), advised["gains"])
        known = runs_at(advised["gains"], [run.trial for run in review.real])
        made = f"real run {known[-1].number}" if known else "not run on the axis"
        mean = marked_number(("recommendation", "mean"), advised["mean"], digits=4)
        std = marked_number(("recommendation", "std"), advised["std"], digits=2)
        unmet = "".join(f"<b>{escape(told)}</b><br>" for told in content["unmet"])
        facts.append(
            f"<b>Recommended</b> {gains}<br>{unmet}<span class=small>{made}; expected "
            f"objective {mean} ± {std}</span>"
        )
    if content["earlier"]:
        taken = marked_count(("earlier",), content["earlier"])
        facts.append(f"<b>{taken} real runs</b> are of an earlier study, and cost nothing here")
    if content["mismatch"]:
        last = content["mismatch"][-1]
        path = ("mismatch", len(content["mismatch"]) - 1, "mismatch")
        shown = marked_number(path, last["mismatch"], digits=2)
        facts.append(f'<b>Mismatch of the twin</b> {shown}, <a href="#trust">over time</a>')
    if content["changes"]:
        facts.append('<b>The plant has changed</b> while it was tuned: <a href="#changes">see</a>')
    if content["twin_versions"]:
        last_twin = content["twin_versions"][-1]["version"]
        facts.append(f'<b>Twin</b> now {escape(last_twin)}, <a href="#changes">why</a>')
    facts.append('<b>Every run</b> <a href="#runs">as a map, as curves and as a table</a>')
    return f'<ul class="key">{"".join(f"<li>{fact}</li>" for fact in facts)}</ul>'


def responses_panel(review: StudyReview) -> str:
    """Draw the first and the best real run over the reference; nothing before a run succeeded."""
    best, first = review.best, review.first
    signal = review.file.objective.signal
    if best is None or first is None or signal not in best.recording.signals:
        return ""
    unit = unit_text(best.recording.units.get(signal, ""))
    lines = []
    reference = review.file.reference.signal
    if reference in best.recording.signals:
        asked = best.recording.signal(reference)
        lines.append(Line("reference", "floor", best.recording.time, np.asarray(asked)))
    if first is not best and signal in first.recording.signals:
        values = first.recording.signal(signal)
        lines.append(Line(f"first, run {first.number}", "before", first.recording.time, values))
    values = best.recording.signal(signal)
    label = f"{review.best_words}, run {best.number}"
    lines.append(Line(label, "after", best.recording.time, values))
    chart = line_chart(
        lines,
        title=f"{words(signal)} of the first and the {review.best_words} real run",
        x_label="time [s]",
        y_label=f"{words(signal)} [{unit}]" if unit else words(signal),
    )
    caption = f"<figcaption><b>{escape(words(signal))}</b> on the real axis</figcaption>"
    return (
        f'<figure class="panel" id="responses" data-first="{first.number}" '
        f'data-best="{best.number}">{caption}{legend(lines)}{chart}</figure>'
    )


def objective_words(review: StudyReview) -> str:
    """Describe the objective in words."""
    weights = review.file.objective.weights
    told = ", ".join(
        f"{words(name)} {number(weight)}" for name, weight in weights.items() if weight > 0.0
    )
    return paragraph(
        "The objective g is a weighted sum of metrics, each less its mean and over its standard "
        f"deviation over the initial runs of the twin; lower is better. Weights: {told}.",
        "soft small",
    )
