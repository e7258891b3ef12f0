"""How sure a statement may sound: "is" or "may be", a name or "one of A, B, C".

All printers take their verb from here, so that none is surer than the probability beside it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from gmfbo.plain_words import words

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.named_effect import NamedEffect

LEAST_FOR_A_FACT = 0.8
"""Probability from which a name is stated as a fact: one such statement in five may be wrong."""

_ROUNDING = 1e-9  # of shares that add up to it

CANNOT_TELL = "the recordings cannot tell them apart"

_WEAKER = {
    "is missing": "may be missing",
    "saturates": "may saturate",
    "follows": "may follow",
    "loses": "may lose",
    "gives": "may give",
    "reads": "may read",
}
"""Main verbs of the catalogue's statements, and how a claim that is not sure says them."""

_VERB = re.compile(rf"\b(?:{'|'.join(_WEAKER)})\b")


def is_sure(probability: float) -> bool:
    """Whether a claim of this probability is stated as a fact; NaN is not."""
    return probability >= LEAST_FOR_A_FACT - _ROUNDING


def with_verb(statement: str, probability: float) -> str:
    """Give a statement the verb that its probability allows.

    Parameters
    ----------
    statement : str
        One sentence that states a fact, such as an effect's in the catalogue.
    probability : float
        Of what it says.

    Returns
    -------
    str
        The same where it is sure. Else its first verb becomes "may ..."; a sentence with an
        unknown verb, as an added effect may have, is preceded by "It may be so:".
    """
    if is_sure(probability):
        return statement
    weaker, found = _VERB.subn(lambda verb: _WEAKER[verb[0]], statement, count=1)
    return weaker if found else f"It may be so: {statement}"


def set_words(effect: NamedEffect) -> str:
    """Name of an effect in words, or "one of A, B, C" where data cannot tell these apart."""
    named = ", ".join(words(name) for name in effect.set)
    return f"one of {named}" if len(effect.set) > 1 else named


def claim(effect: NamedEffect) -> str:
    """Name or set of an effect, with "may be" in front where it is not sure."""
    said = set_words(effect)
    return said if is_sure(effect.set_probability) else f"may be {said}"


def claim_of_set(effect: NamedEffect) -> str:
    """Name or set of an effect as `claim` has it, and why a set is one."""
    return f"{claim(effect)} ({CANNOT_TELL})" if len(effect.set) > 1 else claim(effect)


def label(effect: NamedEffect) -> str:
    """Short name of an effect for a drawing; with a question mark unless it alone is sure."""
    alone = len(effect.set) == 1 and is_sure(effect.set_probability)
    return words(effect.name) if alone else f"{words(effect.name)}?"


def statement_of(
    fact: str,
    names: tuple[str, ...],
    probability: float,
    values: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Say what is missing, no surer than it is.

    Parameters
    ----------
    fact : str
        The law's own sentence, with its size.
    names : tuple of str
        Effects that the data cannot tell apart, the one that fits best first.
    probability : float
        That one of them is at work.
    values : mapping of str to str, optional
        Of each parameter of the twin among them, what it would be: "1.6 ms instead of 1 ms".

    Returns
    -------
    str
        One sentence; of a set it has no size, since each of its laws has another one.
    """
    if len(names) > 1:
        laws = [words(name) for name in names if name not in values]
        named = f"one of {', '.join(laws)}" if len(laws) > 1 else "".join(laws)
        be = "is" if is_sure(probability) else "may be"
        clauses = [f"{named} is missing from the twin"] if laws else []
        clauses += [f"{name.partition(':')[2]} {be} {value}" for name, value in values.items()]
        told = f"{', or '.join(clauses)} ({CANNOT_TELL})."
        fact = told[0].upper() + told[1:] if laws else told
    return with_verb(fact, probability)
