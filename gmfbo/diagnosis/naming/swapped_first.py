"""Whether another law fits better in the first one's place, once others are known beside it."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import fit
from gmfbo.diagnosis.naming.candidate_fits import confirm
from gmfbo.diagnosis.naming.conditions import (
    is_large,
    is_proven,
    margin_over_limit,
    needed_gain,
    simplest,
)
from gmfbo.diagnosis.naming.decision import Beside, Decision, Evidence, Round
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.rivals import rivals_of


def exchange_first(case: Case, decision: Decision, at_work: float) -> bool:
    """Put another law of its family in the first one's place where that is better beside the rest.

    Alone, a law with more freedom makes up for effects that are only found after it, and makes
    them look small; what sets it apart from its limit may be hidden by them. What was found beside
    it is taken back, and so is a search that ended at an effect too small to act on.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        So far; where another law is better its first round is changed, and the further ones go.
        Learns how the first effect and its family do beside the rest.
    at_work : float
        Gain from which an effect that was not named counts as one of the rest.
    """
    beside = _found_beside(case, decision, at_work)
    if not beside:
        return False
    first = decision.rounds[0]
    alternatives = _in_its_place(decision, {e.name for e in beside})
    if not alternatives:
        return False
    last = beside[-1].fitted
    others = replace(last.hypothesis, effects=last.hypothesis.effects[1:])
    without = fit(case.misfit, others, last.parameters, near=last, parallel=True)
    if without is None:
        return False
    own = last.hypothesis.effects[0]
    fits = confirm(case.misfit, without, [own, *(e.effect for e in alternatives)])
    evidence = [evidence_of(case, without, fitted, decision.groups) for fitted in fits]
    needed = needed_gain(decision)
    proven = [
        e for e in evidence if is_proven(case, e, decision, needed) and is_large(case, e, needed)
    ]
    if not any(e.name == first.winner.name for e in proven):
        return False
    # The richer law may have taken what is now found beside it: it needs a whole threshold more.
    chosen = simplest(proven, decision.threshold, decision.threshold)
    alike = tuple(rivals_of(chosen, evidence))
    margin = margin_over_limit(decision.threshold, 0.0)
    entry = Round(chosen, alike, tuple(evidence), needed, margin)
    decision.beside_rest = Beside(without, entry)
    if chosen.name == first.winner.name:
        return False
    winner = next(e for e in alternatives if e.name == chosen.name)
    # What the others tell from it is no rival, however alike the two are alone.
    apart = {e.name for e in evidence} - {e.name for e in alike}
    could = [e for e in first.fitted if e.name not in decision.silent | apart]
    rivals = rivals_of(winner, could)
    decision.rounds[:] = [replace(first, winner=winner, rivals=tuple(rivals))]
    decision.model = winner.fitted
    return True


def _found_beside(case: Case, decision: Decision, at_work: float) -> list[Evidence]:
    """What was named after the first effect, or is at work beside it and was not named."""
    if not decision.rounds:
        return []
    named = [entry.winner for entry in decision.rounds[1:]]
    if named:
        return named
    unnamed = (e for e in decision.refused if is_proven(case, e, decision, at_work))
    return list(islice(unnamed, 1))


def _in_its_place(decision: Decision, named: set[str]) -> list[Evidence]:
    """Laws that were fitted in the first round: its limits, what contains it, and its family."""
    first = decision.rounds[0]
    law = first.winner.effect.law
    return [
        e
        for e in first.fitted
        if e.name not in named | decision.silent and e.name != law.name
        if e.name in law.contains
        or law.name in e.effect.law.contains
        or e.effect.law.family == law.family
    ]
