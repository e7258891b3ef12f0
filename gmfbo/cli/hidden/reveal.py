"""Compare the hidden physics with the diagnosis, and mark it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from gmfbo.cli.hidden.draw import NOTHING, PARAMETERS, Draw
from gmfbo.cli.hidden.effects import EFFECTS, HiddenEffect
from gmfbo.diagnosis.result.certainty import claim, set_words
from gmfbo.plain_words import quantity, words

if TYPE_CHECKING:
    from gmfbo.diagnosis.diagnosis import Diagnosis
    from gmfbo.diagnosis.result.named_effect import NamedEffect

Mark = Literal["right", "one of the set", "missed", "wrong"]

_BY_NAME = {effect.name: effect for effect in EFFECTS}
_NOMINAL = {"inertia": 0.01, "viscous": 0.05}  # of models/servo_axis.fmu
_UNITS = {"inertia": "kg.m2", "viscous": "N.m.s/rad"}
_VERDICTS = {
    "none": NOTHING,
    "parameters": "other parameters, no effect",
    "outside_library": "an effect outside the library",
}


def judged(drawn: Draw, diagnosis: Diagnosis) -> Mark:
    """Mark a diagnosis by the hidden physics.

    Returns
    -------
    {"right", "one of the set", "missed", "wrong"}
        `right`: that effect alone was named, or nothing where nothing was hidden. `one of the
        set`: it was named with others that it cannot be told from. `missed`: it was not named,
        and no other was. `wrong`: something was claimed that is not there.
    """
    if drawn.hidden in (NOTHING, PARAMETERS):
        asked = "none" if drawn.hidden == NOTHING else "parameters"
        if diagnosis.verdict == asked:
            return "right"
        return "missed" if diagnosis.verdict == "none" else "wrong"
    if not diagnosis.effects:
        return "missed"
    marks = [_mark(effect, drawn.hidden) for effect in diagnosis.effects]
    if "wrong" in marks:
        return "wrong"
    return "one of the set" if "one of the set" in marks else "right"


def _mark(effect: NamedEffect, hidden: str) -> Mark:
    rivals = effect.indistinguishable_from
    if hidden not in (effect.name, *rivals):
        return "wrong"
    return "one of the set" if rivals else "right"


def answer_lines(drawn: Draw, diagnosis: Diagnosis) -> list[str]:
    """Table of hidden physics and diagnosis.

    Returns
    -------
    list of str
        A heading, a line with the names, and one for each comparable size and parameter.
    """
    rows = [("", "hidden", "found")]
    rows.append(("effect", _told(drawn.hidden), _named(diagnosis, claim)))
    if drawn.hidden in _BY_NAME:
        rows += _size_rows(_BY_NAME[drawn.hidden], drawn, diagnosis)
    for name, nominal in _NOMINAL.items():
        one = diagnosis.parameters.get(name)
        found = quantity(one.value, one.unit) if one is not None and one.identifiable else "-"
        rows.append((name, quantity(drawn.plant.get(name, nominal), _UNITS[name]), found))
    wide = [max(len(row[column]) for row in rows) for column in (0, 1)]
    return [f"{a:<{wide[0]}}  {b:<{wide[1]}}  {c}".rstrip() for a, b, c in rows]


def _told(hidden: str) -> str:
    return "other parameters, no effect" if hidden == PARAMETERS else words(hidden)


def _named(diagnosis: Diagnosis, say: Callable[[NamedEffect], str]) -> str:
    if not diagnosis.effects:
        return _VERDICTS.get(diagnosis.verdict, words(diagnosis.verdict))
    return " + ".join(say(effect) for effect in diagnosis.effects)


def _size_rows(
    hidden: HiddenEffect, drawn: Draw, diagnosis: Diagnosis
) -> list[tuple[str, str, str]]:
    named = next((one for one in diagnosis.effects if one.name == hidden.name), None)
    values = {name: one.value for name, one in named.parameters.items()} if named else {}
    rows = []
    for size in hidden.sizes:
        found = quantity(size.found(values), size.unit) if values else "-"
        rows.append((size.name, quantity(size.true(drawn.plant), size.unit), found))
    return rows


def explained(drawn: Draw, diagnosis: Diagnosis) -> str:
    """The mark with its reason, in one sentence."""
    mark, hidden = judged(drawn, diagnosis), words(drawn.hidden)
    if mark == "right":
        return {
            NOTHING: "RIGHT: nothing was hidden, and nothing is claimed.",
            PARAMETERS: "RIGHT: only parameters are off, and no effect is claimed.",
        }.get(drawn.hidden, f"RIGHT: it was {hidden}.")
    if mark == "one of the set":
        return f"ONE OF THE SET: it was {hidden}; these recordings do not tell the set apart."
    if mark == "missed":
        if diagnosis.verdict == "outside_library":
            return f"MISSED: it saw that something is there, but did not name {hidden}."
        return f"MISSED: it was {_told(drawn.hidden)}, which was not found."
    if drawn.hidden in (NOTHING, PARAMETERS):
        return (
            f"WRONG: {_told(drawn.hidden)} is the truth; found was {_named(diagnosis, set_words)}."
        )
    if any(effect.name == drawn.hidden for effect in diagnosis.effects):
        return f"WRONG: {hidden} is there, but something else was named beside it that is not."
    return f"WRONG: it was {hidden}, not {_named(diagnosis, set_words)}."
