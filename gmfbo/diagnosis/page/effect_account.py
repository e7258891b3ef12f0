"""Account of one named effect: its law, probability, size and rivals."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.page.charts import part_words
from gmfbo.diagnosis.result.certainty import claim
from gmfbo.pages.html_page import columns, folded, paragraph, table
from gmfbo.pages.marked_number import (
    marked_interval,
    marked_number,
    marked_percent,
    marked_probability,
)
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.named_effect import NamedEffect

_GREEK = {"tau": "τ", "omega": "ω", "phi": "φ", "mu": "μ", "pi": "π"}


def effect_account(place: int, diagnosis: Findings) -> str:
    """Write an effect with its numbers.

    Parameters
    ----------
    place : int
        Index of the effect in the diagnosis.
    diagnosis : Findings
        Result of the diagnosis, which tells the fitted and held-out recordings.
    """
    effect = diagnosis.effects[place]
    own, said = ("effects", place), claim(effect)
    evidence = marked_number((*own, "evidence"), effect.evidence)
    threshold = marked_number((*own, "threshold"), effect.threshold)
    known = marked_probability((*own, "probability"), effect.probability)
    whose = escape(words(effect.name)) if effect.indistinguishable_from else "this effect"
    sure = (
        f"<p>Probability <b>{known}</b> that {whose} is at work. It acts at the "
        f"{escape(words(effect.port))} port.</p>"
    )
    odds = folded(
        "How the probability comes about",
        f"<p>The explanations with and without this effect were compared by how well they fit, "
        f"and by how many free values they need. The logarithm of their odds is {evidence}; from "
        f"{threshold} on, where it is believed at 0.95, an effect is named.</p>"
        + _worth(own, effect),
    )
    return "".join(
        (
            f"<article><h3>{escape(f'{said[:1].upper()}{said[1:]}')}</h3>",
            paragraph(effect.statement),
            f'<p class="law">{law_html(effect.equation)}</p>',
            sure,
            odds,
            _share(own, effect),
            _parameters(place, effect),
            columns(_rivals(place, effect), _recordings(place, effect, diagnosis)),
            "</article>",
        )
    )


def _worth(own: tuple[str | int, ...], effect: NamedEffect) -> str:
    if effect.belief is None:
        return ""
    belief = marked_probability((*own, "belief"), effect.belief)
    whose = "one of them" if effect.indistinguishable_from else "it"
    return (
        f"<p>If one of these explanations were true to the last digit, {whose} would be at work "
        f"with a probability of {belief}. None is: stated is how often effects with such odds "
        "and such errors on unseen recordings were right on simulated axes whose truth was "
        "known.</p>"
    )


def _share(own: tuple[str | int, ...], effect: NamedEffect) -> str:
    if effect.share is None:
        return ""
    value, low, high = (
        marked_percent((*own, "share", end), getattr(effect.share, end))
        for end in ("value", "low", "high")
    )
    return (
        f"<p>Of what is more than noise in the held-out recordings, it explains <b>{value}</b> "
        f"({low} to {high}).</p>"
    )


def _parameters(place: int, effect: NamedEffect) -> str:
    known = CATALOGUE.get(effect.name)
    meaning = {one.name: one.words for one in known.parameters} if known else {}
    rows = []
    for name, one in effect.parameters.items():
        path = ("effects", place, "parameters", name)
        shown = marked_interval(path, one.value, one.low, one.high, one.unit)
        rows.append(
            [
                escape(words(name)),
                escape(meaning.get(name, "")),
                shown.value,
                f"{shown.low} to {shown.high}",
                f'<span class="nowrap">{escape(shown.unit)}</span>',
            ]
        )
    heads = ["parameter", "what it is", "value", "95 % interval", "unit"]
    return table(heads, rows, numbers=(2, 3))


def _rivals(place: int, effect: NamedEffect) -> str:
    if not effect.indistinguishable_from:
        told = "No other effect in the library explains these recordings as well."
        return f"<h4>Rivals</h4>{paragraph(told)}"
    known = CATALOGUE.get(effect.name)
    apart = known.confused_with if known else {}
    shares = {one.name: (k, one) for k, one in enumerate(effect.rivals)}
    rows = []
    for name in (effect.name, *effect.indistinguishable_from):
        share = ""
        if name in shares:
            k, one = shares[name]
            path = ("effects", place, "rivals", k, "probability")
            share = marked_probability(path, one.probability)
        rows.append([escape(words(name)), share, escape(apart.get(name, ""))])
    told = (
        "These explain the recordings as well; equation and values above are those of the first. "
        "The probability on top is that one of them is at work; here is that of each."
    )
    listed = table(["rival", "probability", "what would tell it apart"], rows, numbers=(1,), best=0)
    return f"<h4>Rivals</h4>{paragraph(told)}{listed}"


def _recordings(place: int, effect: NamedEffect, diagnosis: Findings) -> str:
    whole = sum(abs(gain) for gain in effect.evidence_per_recording.values())
    if not whole > 0.0:
        return ""
    rows = [
        [
            escape(name),
            part_words(diagnosis, name),
            marked_number(
                ("effects", place, "evidence_per_recording", name),
                gain,
                factor=0.01 * whole,
                digits=2,
            )
            + "\u00a0%",
        ]
        for name, gain in effect.evidence_per_recording.items()
    ]
    told = paragraph("Share of each recording in what speaks for this effect.", "soft small")
    listed = table(["recording", "part", "share"], rows, numbers=(2,))
    return f"<h4>Which recordings show it</h4>{told}{listed}"


def law_html(equation: str) -> str:
    """Set the text of an equation.

    Parameters
    ----------
    equation : str
        As an effect states it, such as `tau = -F_c * sign(omega)`.

    Returns
    -------
    str
        HTML; what is not understood stays as it is.
    """
    text = escape(equation)
    text = re.sub(
        r"\b([A-Za-z]+)_([A-Za-z0-9]+)\b",
        lambda m: f"{_GREEK.get(m[1], m[1])}<sub>{m[2]}</sub>",
        text,
    )
    text = re.sub(r"\b(tau|omega|phi|mu|pi)\b", lambda m: _GREEK[m[1]], text)
    text = re.sub(r"\^(-?\w+)", r"<sup>\1</sup>", text)
    return text.replace(" * ", "\u202f·\u202f").replace("-", "−").replace("&lt;=", "≤")
