"""The verdict of a diagnosis in plain words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gmfbo.diagnosis.result.cautions import (
    are_sure,
    not_compared,
    range_ends,
    too_narrow_ranges,
    withheld_twin,
)
from gmfbo.diagnosis.result.certainty import is_sure
from gmfbo.diagnosis.result.removed_error import (
    STILL_FOLLOWS,
    explains_most,
    follows_clearly,
    remainder_words,
    resembling_words,
    still_follows,
)
from gmfbo.plain_words import NOT_EXCITED, listed, number, percent, quantity, words
from gmfbo.units import quantity as prefixed

if TYPE_CHECKING:
    from gmfbo.diagnosis.result.estimated import EstimatedParameter
    from gmfbo.diagnosis.result.findings import Findings
    from gmfbo.diagnosis.result.named_effect import NamedEffect
    from gmfbo.diagnosis.result.next_experiment import NextExperiment

_FAR_ABOVE = 2.0  # times the noise floor: nobody calls that "to the noise"


def verdict_sentence(diagnosis: Findings) -> str:
    """Verdict of a diagnosis, in one or a few sentences."""
    told = {
        "none": _nothing,
        "parameters": _parameters,
        "missing_physics": _physics,
        "outside_library": _outside,
    }[diagnosis.verdict](diagnosis)
    left = remainder_words(diagnosis.remainder) if diagnosis.effects else ""
    told = f"{told}{f' {left[0].upper()}{left[1:]}.' if left else ''}{_unseen(diagnosis)}"
    narrow, ends = too_narrow_ranges(diagnosis), range_ends(diagnosis)
    # What a range holds back could do what is missing: it is said before anything is blamed.
    parts = (narrow, ends, told) if diagnosis.verdict == "outside_library" else (narrow, told, ends)
    # What was not looked at comes before anything that is called right.
    return " ".join(filter(None, (not_compared(diagnosis), *parts, withheld_twin(diagnosis))))


def _nothing(diagnosis: Findings) -> str:
    if diagnosis.evidence == "insufficient":
        return "These recordings cannot tell: they show no left-out physics, but excite too little."
    fits = diagnosis.fit.signals
    errors = ", ".join(
        f"{words(name)} error {percent(fit.nominal)}{_floor(fit.noise_floor)}"
        for name, fit in list(fits.items())[:3]
    )
    where = "In what was compared, nothing" if diagnosis.not_compared else "Nothing"
    nominal = {name: fit.nominal for name, fit in fits.items()}
    uncorrected = _uncorrected(diagnosis, "nominal")
    if left := _left_over(diagnosis, nominal):
        return f"{where} that is known here is missing, though {left}.{uncorrected}"
    if not errors:
        return f"{where} is missing: the twin meets the recordings to the noise."
    met = f"the twin meets unseen recordings to the noise ({errors})"
    return f"{where} is missing: {met}.{uncorrected}"


def _parameters(diagnosis: Findings) -> str:
    moved = {
        name: parameter
        for name, parameter in diagnosis.parameters.items()
        if parameter.identifiable and parameter.is_moved and not parameter.is_beyond
    }
    values = ", ".join(_instead(name, one) for name, one in list(moved.items())[:3])
    more = f" and {len(moved) - 3} more" if len(moved) > 3 else ""
    told = f": {values}{more}" if values else ""
    hidden = [name for name, one in diagnosis.parameters.items() if not one.identifiable]
    if hidden and not moved and diagnosis.combinations:
        told = (
            f"; of {listed(hidden)} these recordings tell only "
            f"{listed(f'{one.expression} = {number(one.value)}' for one in diagnosis.combinations)}"
        )
    missing = "no physics is missing"
    refitted = {
        name: fit.augmented if math.isfinite(fit.augmented) else fit.parameters_only
        for name, fit in diagnosis.fit.signals.items()
    }
    if left := _left_over(diagnosis, refitted):
        missing = f"no physics that is known here is missing, though {left}"
    if too_narrow_ranges(diagnosis):
        return f"With such values the twin explains the difference{told}; {missing}."
    whose = "" if any(one.fixed for one in moved.values()) else "uncertain "
    is_sure_of_all = are_sure(diagnosis) and not diagnosis.fit.twin_is_withheld
    verb = "explain" if is_sure_of_all else "may explain"
    model = "augmented" if any(one.fixed for one in moved.values()) else "parameters_only"
    uncorrected = _uncorrected(diagnosis, model)
    return f"The twin's {whose}values {verb} the difference{told}; {missing}.{uncorrected}"


def _uncorrected(diagnosis: Findings, model: str) -> str:
    """Sentence on an open-loop twin that is far off once nothing corrects it; else empty."""
    off = {}
    for name, fit in diagnosis.fit.signals.items():
        free = math.nan if fit.free_run is None else getattr(fit.free_run, model)
        if free > _FAR_ABOVE * max(getattr(fit, model), fit.noise_floor):
            off[name] = free
    if not off:
        return ""
    worst = max(off, key=lambda name: off[name])
    return (
        f" Over whole recordings, where nothing corrects the twin, the {words(worst)} error is "
        f"{percent(off[worst])}."
    )


def _left_over(diagnosis: Findings, errors: Mapping[str, float]) -> str:
    """Clause on what is more than noise beside nothing that was named; empty where nothing is."""
    follows = follows_clearly(diagnosis)
    floors = {name: fit.noise_floor for name, fit in diagnosis.fit.signals.items()}
    over = {name: errors[name] / floor for name, floor in floors.items() if floor > 0.0}
    name = max(over, key=lambda signal: over[signal], default="")
    is_far = bool(over) and over[name] > _FAR_ABOVE
    if diagnosis.effects or not (follows or is_far or remainder_words(diagnosis.remainder)):
        return ""
    told = STILL_FOLLOWS if follows else "more than noise is left"
    if not over or not over[name] > 1.0:
        return told
    shown = f"{words(name)} error {percent(errors[name])}{_floor(floors[name])}"
    return f"{told} ({shown})"


def _freed(diagnosis: Findings) -> str:
    """Sentences on fixed values that are wrong beside what is missing; empty where none is."""
    return " ".join(
        f"{_instead(name, one)}."
        for name, one in diagnosis.parameters.items()
        if one.fixed and one.is_moved
    )


def _instead(name: str, one: EstimatedParameter) -> str:
    """Clause on a value that is another than in the twin."""
    nominal = quantity(one.nominal, "")
    verb = "is" if one.probability is None or is_sure(one.probability) else "may be"
    return f"{name} {verb} {quantity(one.value, one.unit)} instead of {nominal}{one.where_fixed}"


def _with_what(diagnosis: Findings) -> str:
    """What stands for the named effects: of a set the first, with whose values errors are told."""
    first, *others = diagnosis.effects
    sets = any(effect.indistinguishable_from for effect in diagnosis.effects)
    if others:
        return "the first of each set" if sets else "them"
    return words(first.name) if sets else "it"


def _physics(diagnosis: Findings) -> str:
    first, *others = diagnosis.effects
    improved = _improvement(diagnosis)
    sets = [effect for effect in diagnosis.effects if effect.indistinguishable_from]
    if not others:
        tail = f"; with {_with_what(diagnosis)} {improved}." if improved else "."
        told = first.statement.rstrip(". ") + tail
    else:
        told = " ".join(effect.statement for effect in diagnosis.effects)
        told += f" With {_with_what(diagnosis)} {improved}." if improved else ""
    apart = next(filter(None, (_apart(diagnosis.next_experiment, effect) for effect in sets)), "")
    return " ".join(filter(None, (told, _freed(diagnosis), apart)))


def _apart(planned: NextExperiment | None, effect: NamedEffect) -> str:
    """Sentence on the experiment that would tell a set apart; empty where none is known."""
    if planned is None or not planned.reference or planned.distance < planned.threshold:
        return ""
    # A rival of several effects is named by all of them, joined by " + ".
    told_apart = {part for name in planned.separates for part in name.split(" + ")}
    rivals = [words(name) for name in effect.set if name in told_apart]
    return f"Play {planned.reference} to tell {' from '.join(rivals)}." if len(rivals) > 1 else ""


def _outside(diagnosis: Findings) -> str:
    from gmfbo.physics import CATALOGUE

    silent = {entry.name for entry in diagnosis.not_testable}
    count = len(CATALOGUE) - len(silent)
    if count <= 0:
        return (
            "Something is missing, and none of the effects known here can be tested with this twin."
        )
    which = f"{count} effects known here{' that could be tested' if silent else ''}"
    if diagnosis.effects:
        if explains_most(diagnosis.remainder):
            return " ".join(filter(None, (_physics(diagnosis), _stand_ins(diagnosis))))
        nearest = " ".join(effect.statement for effect in diagnosis.effects)
        told = f"None of the {which} explains all that is missing. The nearest: {nearest}"
        improved = _improvement(diagnosis)
        change = f"With {_with_what(diagnosis)} {improved}." if improved else ""
        instead = _stand_ins(diagnosis)
        return " ".join(filter(None, (told, change, instead, _freed(diagnosis))))
    told = f"Something is missing that is none of the {which}{_function(diagnosis)}."
    return " ".join(filter(None, (told, _stand_ins(diagnosis), _freed(diagnosis))))


def _stand_ins(diagnosis: Findings) -> str:
    """Sentence on laws that the corrected twin has in the place of what is unknown."""
    left = diagnosis.remainder
    if left is None or not left.stand_ins:
        return ""
    told = listed(map(words, left.stand_ins))
    improved = "" if diagnosis.effects else _improvement(diagnosis)
    one = len(left.stand_ins) == 1
    verbs = ("comes", "stands", "it") if one else ("come", "stand", "them")
    tail = f": with {verbs[2]} {improved}" if improved else ""
    return (
        f"{told[0].upper()}{told[1:]} {verbs[0]} nearest and {verbs[1]} in for it in the corrected "
        f"twin{tail}."
    )


def _function(diagnosis: Findings) -> str:
    """Clause on where something without a name acts, and on what it depends; "" if not known."""
    shape, left = diagnosis.shape, diagnosis.remainder
    alike = resembling_words(left)
    if left is not None and left.port is not None and left.against is not None:
        place = (left.port, left.against)
        if shape is None or (shape.port, shape.against.partition(",")[0]) != place:
            return _acts(*place, alike)
    if shape is None or not shape.y:
        return ""
    if not math.isfinite(shape.largest):
        return _acts(shape.port, shape.against, alike)
    return (
        f": up to {prefixed(shape.largest, shape.unit_y)} at the {words(shape.port)} port that "
        f"depends on the {words(shape.against)}{alike}"
    )


def _acts(port: str, against: str, alike: str) -> str:
    return f": it acts at the {words(port)} port and depends on the {words(against)}{alike}"


def _improvement(diagnosis: Findings) -> str:
    """Words for the error that the physics reduces most; empty where no error falls."""
    name = diagnosis.fit.most_improved
    if name is None:
        return ""
    fit = diagnosis.fit.signals[name]
    before, after = percent(fit.parameters_only), percent(fit.augmented)
    if before == after:
        before, after = (f"{100.0 * v:.3g} %" for v in (fit.parameters_only, fit.augmented))
    left = f"; {STILL_FOLLOWS}" if still_follows(diagnosis) else ""
    change = f"falls from {before} to" if before != after else "hardly changes, it is"
    return (
        f"the {words(name)} error on unseen recordings {change} {after}"
        f"{_floor(fit.noise_floor, '()')}{left}"
    )


def _floor(noise_floor: float, around: str = "") -> str:
    if not math.isfinite(noise_floor):
        return ""
    text = f"noise floor {percent(noise_floor)}"
    return f" ({text})" if around else f", {text}"


def _unseen(diagnosis: Findings) -> str:
    """Words for the number of effects that could not be tested, where it matters."""
    if diagnosis.evidence == "sufficient":
        return ""
    silent = sum(entry.why.startswith(NOT_EXCITED) for entry in diagnosis.not_testable)
    told = f" They do not excite {silent} of the known effects." if silent else ""
    if diagnosis.verdict != "none":
        told = f" These recordings cannot tell more.{told}"
    planned = diagnosis.next_experiment
    if planned is not None and planned.reference:
        told += f" Record {planned.reference} next."
    return told
