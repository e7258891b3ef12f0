"""The account of one named effect: what, how sure, how large, and what it may be instead."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gmfbo.diagnosis.plain_words import number, probability, unit_words, words
from gmfbo.physics import CATALOGUE
from gmfbo.reports.html_page import paragraph, table

if TYPE_CHECKING:
    from gmfbo.diagnosis import Diagnosis
    from gmfbo.diagnosis.named_effect import NamedEffect

DIGITS = 4


def effect_account(effect: NamedEffect, diagnosis: Diagnosis) -> str:
    """Write an effect with its numbers.

    Parameters
    ----------
    effect : NamedEffect
        One of those that the diagnosis names.
    diagnosis : Diagnosis
        The whole, for what was fitted on what.

    Returns
    -------
    str
        HTML.
    """
    sure = (
        f"Probability {probability(effect.probability)}. Evidence {number(effect.evidence, DIGITS)}"
        f" (named from {number(effect.threshold, DIGITS)}), at the {words(effect.port)} port."
    )
    return "".join(
        (
            f"<article><h3>{escape(words(effect.name).capitalize())}</h3>",
            paragraph(effect.statement),
            f"<p><code>{escape(effect.equation)}</code></p>",
            paragraph(sure),
            _parameters(effect),
            _rivals(effect),
            _recordings(effect, diagnosis),
            "</article>",
        )
    )


def _parameters(effect: NamedEffect) -> str:
    known = CATALOGUE.get(effect.name)
    meaning = {one.name: one.words for one in known.parameters} if known else {}
    rows = [
        [
            name,
            meaning.get(name, ""),
            number(one.value, DIGITS),
            f"{number(one.low, DIGITS)} to {number(one.high, DIGITS)}",
            unit_words(one.unit),
        ]
        for name, one in effect.parameters.items()
    ]
    return table(
        ["parameter", "what it is", "value", "95 % interval", "unit"], rows, numbers=(2, 3)
    )


def _rivals(effect: NamedEffect) -> str:
    if not effect.indistinguishable_from:
        return paragraph("No other effect in the library explains these recordings as well.")
    known = CATALOGUE.get(effect.name)
    apart = known.confused_with if known else {}
    rows = [[words(name), apart.get(name, "")] for name in effect.indistinguishable_from]
    told = (
        "These explain the recordings as well; the probability is that of all of them together "
        "with the named one."
    )
    return paragraph(told) + table(["rival", "what would tell it apart"], rows)


def _recordings(effect: NamedEffect, diagnosis: Diagnosis) -> str:
    unseen = set(diagnosis.fit.held_out)
    rows = [
        [name, "unseen" if name in unseen else "fitted on", number(gain, DIGITS)]
        for name, gain in effect.evidence_per_recording.items()
    ]
    return table(["recording", "part", "evidence"], rows, numbers=(2,))
