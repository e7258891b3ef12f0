"""First screen of the page: verdict, curves of a held-out recording, and errors in numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.charts import STYLES, WORDS, before_and_after_panels
from gmfbo.diagnosis.result.cautions import are_sure
from gmfbo.diagnosis.result.certainty import claim_of_set, is_sure
from gmfbo.diagnosis.result.misaligned_columns import misaligned_sentence
from gmfbo.diagnosis.result.removed_error import (
    STILL_FOLLOWS,
    explains_most,
    remainder_words,
    removed_percent,
    still_follows,
)
from gmfbo.diagnosis.result.sentence import verdict_sentence
from gmfbo.pages.html_page import paragraph, table
from gmfbo.pages.marked_number import (
    marked,
    marked_interval,
    marked_number,
    marked_percent,
    marked_probability,
    scale_for,
)
from gmfbo.pages.svg_chart import swatch
from gmfbo.plain_words import percent, words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import EstimatedParameter
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.held_out_errors import Fit
    from gmfbo.diagnosis.result.named_effect import NamedEffect

VERDICTS: Mapping[str, str] = {
    "none": "nothing is missing",
    "parameters": "parameters explain it",
    "missing_physics": "physics is missing",
    "outside_library": "unknown physics",
}
"""Name of each verdict on the page."""

_HEADLINE = 290  # characters that a headline may have: three lines
_QUANTITY = re.compile(
    r"\d (?:%|(?:kg|[mµkM]?(?:N|rad|s|m|V|A|W|Hz))(?:[/\d][\w/()]*)?"
    r"(?: (?:m|s)(?:[/\d][\w/()]*)?)*)"
    r"(?=[\s,.;:)]|$)"
)
_ASSURING = ("coulomb_friction", "backlash", "transport_delay", "cogging_torque")
_MODELS = ("nominal", "parameters_only", "augmented", "unnamed_spline", "noise_floor")
_UNCORRECTED = ("nominal", "parameters_only", "augmented")
_SWATCHES = {**STYLES, "unnamed_spline": "spline", "noise_floor": "floor"}


def first_screen(diagnosis: Findings) -> str:
    """Write the part of the page that shows before scrolling.

    Returns
    -------
    str
        HTML; recordings beyond the first are folded below it.
    """
    panels = before_and_after_panels(diagnosis)
    numbers = f'<div class="numbers">{_error_table(diagnosis)}{_key_facts(diagnosis)}</div>'
    shown = f'<div class="panels">{panels[0]}</div>' if panels else ""
    layout = "first" if panels else "first alone"
    more = "".join(panels[1:])
    if more:
        more = (
            '<details class="more-panels"><summary>Other signals and recordings</summary>'
            f'<div class="columns">{more}</div></details>'
        )
    return f'{_head(diagnosis)}<div class="{layout}">{shown}{numbers}</div>{more}'


def _head(diagnosis: Findings) -> str:
    verdict = verdict_words(diagnosis)
    twin = diagnosis.augmentation.twin_name if diagnosis.augmentation else ""
    enough = {
        "sufficient": "these recordings move the axis enough to tell",
        "insufficient": "these recordings move the axis too little to tell",
    }[diagnosis.evidence]
    named = f"<span>Diagnosis of <b>{escape(twin)}</b></span>" if twin else "<span>Diagnosis</span>"
    headline, rest = _split_sentence(verdict_sentence(diagnosis))
    return (
        f'<header><div class="top">{named}'
        f'<span class="badge {diagnosis.verdict}">{verdict}</span>'
        f"<span>{enough}</span>{_sure(diagnosis)}</div>"
        f'<h1 id="verdict">{escape(unbroken(headline))}</h1>'
        f"{paragraph(unbroken(rest), 'lead')}</header>"
    )


def verdict_words(diagnosis: Findings) -> str:
    """Name of the verdict; physics of which no name is sure only "may be missing"."""
    sure = any(is_sure(effect.set_probability) for effect in diagnosis.effects)
    told = VERDICTS[diagnosis.verdict]
    if diagnosis.verdict == "outside_library" and sure and explains_most(diagnosis.remainder):
        return "known and unknown physics"
    if diagnosis.verdict == "parameters" and not are_sure(diagnosis):
        return "parameters may explain it"
    return told if sure or diagnosis.verdict != "missing_physics" else "physics may be missing"


def _sure(diagnosis: Findings) -> str:
    """Probability of what the headline says, where the diagnosis has one."""
    known = diagnosis.statement_probability
    if known is None:
        return ""
    shown = marked_probability(("statement_probability",), known)
    return f"<span>probability of this statement {shown}</span>"


def unbroken(text: str) -> str:
    """Keep numbers and their units on one line."""
    return _QUANTITY.sub(lambda found: found[0].replace(" ", "\u00a0"), text)


def _split_sentence(sentence: str) -> tuple[str, str]:
    """Headline and rest of a verdict; the whole and nothing where it is short."""
    if len(sentence) <= _HEADLINE:
        return sentence, ""
    ends = [found.end() - 1 for found in re.finditer(r"[.] (?=[A-Z])", sentence)]
    fitting = [end for end in ends if end <= _HEADLINE] or ends[:1]
    if not fitting:
        return sentence, ""
    return sentence[: fitting[-1]], sentence[fitting[-1] + 1 :]


def _error_table(diagnosis: Findings) -> str:
    fit = diagnosis.fit
    if not fit.signals:
        return ""
    known = [
        model
        for model in _MODELS
        if any(math.isfinite(getattr(one, model)) for one in fit.signals.values())
    ]
    rows = [
        [
            f"{swatch(_SWATCHES[model])}{WORDS[model]}",
            *(
                marked_percent(("fit", "signals", name, model), getattr(one, model))
                for name, one in fit.signals.items()
            ),
        ]
        for model in known
    ]
    rows += _free_runs(fit)
    heads = ["error, unseen recordings", *(words(name) for name in fit.signals)]
    best = known.index("augmented") if "augmented" in known else None
    told = table(heads, rows, numbers=range(1, len(heads)), style="wide errors", best=best)
    return told + paragraph("RMS error over the range of the recorded signal.", "soft small")


def _free_runs(fit: Fit) -> list[list[str]]:
    """Errors of an open-loop twin that nothing corrects."""
    if not any(one.free_run for one in fit.signals.values()):
        return []
    return [
        [
            f"{swatch(_SWATCHES[model])}{WORDS[model]}, whole and uncorrected",
            *(
                marked_percent(
                    ("fit", "signals", name, "free_run", model), getattr(one.free_run, model)
                )
                if one.free_run
                else ""
                for name, one in fit.signals.items()
            ),
        ]
        for model in _UNCORRECTED
    ]


def _key_facts(diagnosis: Findings) -> str:
    facts = [_effect_fact(place, effect) for place, effect in enumerate(diagnosis.effects)]
    facts += _removed(diagnosis)
    facts += _left(diagnosis)
    # A refit moves uncertain values a little beside any effect; a fixed one contradicts the file.
    alone = not diagnosis.effects and diagnosis.shape is None
    facts += _moved_parameters(
        {name: one for name, one in diagnosis.parameters.items() if alone or one.fixed}
    )
    facts += _would_have_shown(diagnosis) if alone else []
    if misaligned := misaligned_sentence(diagnosis):
        facts.append(escape(misaligned))
    where = place_words(diagnosis)
    if where:
        facts.append(f'<b>Where</b> <a href="#where">{escape(where)}</a>')
    if diagnosis.next_experiment is not None:
        facts.append('<b>Next</b> <a href="#next">the recording that would tell more</a>')
    return f'<ul class="key">{"".join(f"<li>{fact}</li>" for fact in facts)}</ul>' if facts else ""


def _removed(diagnosis: Findings) -> list[str]:
    told, share = removed_percent(diagnosis), diagnosis.fit.explainable_error_removed
    if not told or share is None:
        return []
    # Of a share that is rounded down, two of the three digits shown are those of the JSON.
    digits = None if told == percent(share) else 2
    path = ("fit", "explainable_error_removed")
    shown = marked(path, told.removesuffix(" %"), factor=0.01, digits=digits)
    left = f"; {STILL_FOLLOWS}" if still_follows(diagnosis) else ""
    return [f"<b>{shown}\u00a0%</b> of the error that physics can explain is removed{left}"]


def _left(diagnosis: Findings) -> list[str]:
    """What no law explains."""
    told, remainder = remainder_words(diagnosis.remainder), diagnosis.remainder
    if not told or remainder is None:
        return []
    shown, bare = marked_percent(("remainder", "share"), remainder.share), percent(remainder.share)
    if not told.startswith(bare):  # less than is told
        return [escape(told)]
    return [f"<b>{shown}</b>{escape(told.removeprefix(bare))}"]


def _moved_parameters(parameters: Mapping[str, EstimatedParameter]) -> list[str]:
    """Parameters whose refitted interval leaves out the value in the twin."""
    facts = []
    for name, one in parameters.items():
        if not (one.identifiable and one.is_moved):
            continue
        path = ("parameters", name)
        shown = marked_interval(path, one.value, one.low, one.high, one.unit)
        ends = (one.value, one.low, one.high)
        factor = scale_for(max(abs(end) for end in ends), one.unit).factor
        nominal = marked_number((*path, "nominal"), one.nominal, factor=factor, digits=4)
        where = escape(one.where_fixed)
        facts.append(f"<b>{escape(name)}</b> = {shown.text}, in the twin {nominal}{where}")
    return facts[:4]


def _would_have_shown(diagnosis: Findings) -> list[str]:
    """Smallest detectable sizes of common effects, as evidence that nothing is missing."""
    sizes = []
    for name in _ASSURING:
        if name in diagnosis.detectable:
            one = diagnosis.detectable[name]
            scale = scale_for(one.size, one.unit, share=True)
            path = ("detectable", name, one.parameter)
            size = marked_number(path, one.size, factor=scale.factor, digits=2)
            sizes.append(f"{escape(words(name))} from {size}\u00a0{escape(scale.unit)}")
    if not sizes:
        return []
    return [
        f'<b>Looked for, and not found</b>: {", ".join(sizes)}, <a href="#shown">and others</a>'
    ]


def _effect_fact(place: int, effect: NamedEffect) -> str:
    own = ("effects", place)
    sure = marked_probability((*own, "set_probability"), effect.set_probability)
    values = []
    for name, one in list(effect.parameters.items())[:2]:
        path = (*own, "parameters", name)
        shown = marked_interval(path, one.value, one.low, one.high, one.unit)
        values.append(f'<span class="nowrap">{escape(words(name))} = {shown.text}</span>')
    if len(effect.parameters) > len(values):
        values.append('<a href="#missing">more</a>')
    head = f"as {escape(words(effect.name))}: " if effect.indistinguishable_from else ""
    return (
        f"<b>{escape(_capital(claim_of_set(effect)))}</b>, probability {sure}<br>"
        f'<span class="small">{head}{", ".join(values)}</span>'
    )


def _capital(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}"


def place_words(diagnosis: Findings) -> str:
    """Tell where the mismatch sits: part of the loop, and state in which it acts."""
    location = diagnosis.location
    path = f"in the {location.signal_path}" if location.signal_path else ""
    joint = "; " if location.region.startswith("it ") else ", "
    return joint.join(part for part in (path, location.region) if part)
