"""Which names stand, after all that was found is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case, is_more_than_noise, times_noise
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.naming.conditions import is_large, is_proven
from gmfbo.diagnosis.naming.decision import Decision, Round, model_after
from gmfbo.diagnosis.naming.rivals import rivals_of
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.plain_words import number, words

LEAST_PROBABILITY = 0.3
"""Below it an effect is not named: it is more likely wrong than right."""

_MOST = 0.5  # of the misfit beyond noise, which names may leave of a twin that is held

_BEYOND_DOUBT = 5.0
"""times what an effect has to gain: what acts for milliseconds is hardly seen in an RMS error."""


def note_what_is_not_named(case: Case, decision: Decision) -> None:
    """Say of what explains these recordings and is not named why it is not."""
    if decision.in_doubt is not None:
        name = words(decision.in_doubt.name)
        case.notes.append(
            f"{name} would explain these recordings as well as anything, but they hold no "
            "reversal that could tell: nothing is named"
        )
    if decision.too_small is not None:
        name = words(decision.too_small.name)
        case.notes.append(
            f"{name} explains what is left, but it is smaller than anybody would act on: it is "
            "not named"
        )
    if decision.disputed is not None and is_more_than_noise(case, case.base):
        name = words(decision.disputed.name)
        case.notes.append(
            f"{name} would explain more of these recordings than anything else, but some of them "
            "speak against it: something acts that is like it, and is not it"
        )
    if decision.unsettled is not None:
        lasting = number(decision.unsettled.effect.values["duration"])
        case.notes.append(
            "the axis was not at rest when these recordings began: what seems to act in their "
            f"first {lasting} s is not named; hold the first reference for longer beforehand"
        )


def give_way_to_limit(
    case: Case,
    decision: Decision,
    probabilities: dict[str, float],
    judged: Callable[[Fitted, Round], float],
) -> None:
    """Name the limit of the last law in its place where that is the more probable one.

    A law that would hardly have been named if it were true is not named, but its limit may well be.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        So far; its last round may get another winner.
    probabilities : dict of str to float
        Of each name; learns that of the limit.
    judged : callable (Fitted, Round)
        Probability of a winner, about the twin without it.
    """
    if not decision.rounds:
        return
    *before, last = decision.rounds
    if probabilities[last.winner.name] >= LEAST_PROBABILITY:
        return
    without = model_after(before, case.base)
    earlier = replace(decision, rounds=before, model=without)
    could = [e for e in last.fitted if e.name not in decision.silent]
    limits = [
        e
        for e in could
        if e.name in last.winner.effect.law.contains
        if is_proven(case, e, earlier, last.needed) and is_large(case, e, last.needed)
    ]
    for limit in sorted(limits, key=lambda e: -e.gain):
        entry = replace(last, winner=limit, rivals=tuple(rivals_of(limit, could)))
        probability = judged(without, entry)
        if probability >= LEAST_PROBABILITY:
            probabilities[limit.name] = probability
            decision.rounds[-1] = entry
            decision.model = limit.fitted
            return


def drop_improbable(case: Case, decision: Decision, probabilities: dict[str, float]) -> None:
    """Leave out a name that is most likely wrong, and what was found beside it."""
    for place, entry in enumerate(decision.rounds):
        if probabilities[entry.winner.name] < LEAST_PROBABILITY:
            decision.refused = [entry.winner]
            del decision.rounds[place:]
            decision.model = model_after(decision.rounds, case.base)
            return


def leaves_most(case: Case, decision: Decision) -> bool:
    """Whether names leave most of a held twin's misfit beyond noise: then it may be coloured noise.

    The loop that holds an open-loop twin on its recordings makes noise follow the motion, so that
    nothing else tells the two apart.
    """
    if case.simulations.tracking is None or decision.model is None or not decision.rounds:
        return False
    left = times_noise(case, decision.model) - 1.0
    before = times_noise(case, case.base) - 1.0
    return is_more_than_noise(case, decision.model) and left > _MOST * before


def is_weak(decision: Decision) -> bool:
    """Whether there are names, and none of them is beyond doubt."""
    return bool(decision.rounds) and all(
        entry.winner.gain < _BEYOND_DOUBT * entry.needed for entry in decision.rounds
    )


def is_known(decision: Decision) -> bool:
    """Whether an effect of the library does it, though it cannot be named."""
    return decision.in_doubt is not None or decision.too_small is not None


def parameters_matter(case: Case, decision: Decision) -> bool:
    """Whether refitting the uncertain parameters gains the threshold over the nominal ones."""
    nominal = case.misfit.residual(case.simulations.run([Point()])[0])
    before = float(sum(np.sum(block**2) for block in nominal))
    return before - case.base.chi2 > decision.threshold
