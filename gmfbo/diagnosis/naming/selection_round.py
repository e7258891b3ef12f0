"""One effect more: what is worth a fit, what the fits show, and which of them is accepted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case, chi2_per_dof, is_more_than_noise
from gmfbo.diagnosis.case.other_starts import fitted_without_last
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.candidate_fits import (
    LAGS,
    MISLED,
    MOST,
    confirm,
    rough_worth_fitting,
    shortlist,
)
from gmfbo.diagnosis.naming.conditions import (
    begins_with_recordings,
    is_disputed,
    is_large,
    is_proven,
    is_shadow,
    is_small_elsewhere,
    margin_over_limit,
    needed_gain,
    simplest,
    slack_of,
)
from gmfbo.diagnosis.naming.decision import Decision, Evidence, Round, model_after
from gmfbo.diagnosis.naming.evidence_of_fit import evidence_of
from gmfbo.diagnosis.naming.gain_by_chance import gain_by_chance
from gmfbo.diagnosis.naming.library_dispersion import best_of, widen_budget
from gmfbo.diagnosis.naming.rivals import rivals_of
from gmfbo.diagnosis.naming.start_at_rest import begun_better
from gmfbo.diagnosis.naming.threshold import NullGains
from gmfbo.diagnosis.screening.limit_scan import scan_limits
from gmfbo.diagnosis.screening.probes import Probe, Screened, refined, screen
from gmfbo.diagnosis.screening.trials import with_effect
from gmfbo.physics import CATALOGUE

_UNEVEN = 1.4  # times the median stretch
_GROSS = 2.0  # chi2 per degree of freedom, above which refitted parameters mislead
_FAR_MORE = 2.0  # times the gain of what is proven, or of what is asked for
_WORTH_FITTING = 8.0  # gain by screening below which no fit is tried
_PROMISING = 200.0  # gain by screening from which it is asked whether fits keep what it promised
_ELSEWHERE = 0.05  # of a parameter, by which a fit is another one
_KEPT_PROMISE = 0.25  # of it, below which what it ranked next is fitted too


def fits_of_round(case: Case, decision: Decision, rng: np.random.Generator) -> list[Fitted]:
    """Fit what is worth it beside what is named so far.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget; learns how the recordings begin.
    decision : Decision
        So far.
    rng : numpy Generator
        Of the noise under which limits are looked for.
    """
    assert decision.model is not None
    named = {c.effect for c in decision.model.hypothesis.effects}
    tried = [p for p in decision.tried if p.candidate.effect not in with_limits(named)]
    screened = screen(case.misfit, decision.model, tried, decision.groups)
    if screened and screened[0].gain > _WORTH_FITTING:
        screened = refined(case.misfit, decision.model, screened, decision.groups)
    if not decision.rounds:
        decision.screened = screened
    chosen = shortlist(screened, _WORTH_FITTING)
    families = _to_try(case, decision.model)
    known = {c.effect for c in chosen}
    chosen += rough_worth_fitting(case.misfit, decision.model, tried, families, known)
    chosen = _with_limits_scanned(case, decision, tried, chosen, rng)
    fits = _confirmed(case, decision, screened, chosen)
    fits = _begun_alone(case, decision, fits)
    decision.model, fits = begun_better(case, decision.model, fits)
    return fits


def _begun_alone(case: Case, decision: Decision, fits: Sequence[Fitted]) -> list[Fitted]:
    """Fit effects beside the names from where they were found alone, too, and keep the better fits.

    What an effect does, parameters may have made up for while another one was fitted: from there no
    small step leads back (a delay, behind an inertia that grew by a quarter).
    """
    model = decision.model
    assert model is not None
    if not decision.rounds:
        return list(fits)
    best = {f.hypothesis.effects[-1].effect: f for f in fits}
    taken = with_limits({c.effect for c in model.hypothesis.effects})
    alone = [
        e.fitted
        for e in decision.rounds[-1].fitted
        if e.name not in taken and e.gain > decision.threshold and _is_elsewhere(e.fitted, model)
    ][:MOST]

    def beside(found: Fitted) -> Fitted | None:
        joined = with_effect(model.hypothesis, found.hypothesis.effects[-1])
        return fit(case.misfit, joined, found.parameters, near=found)

    for moved in case.misfit.simulations.map_outer(beside, alone):
        if moved is None:
            continue
        name = moved.hypothesis.effects[-1].effect
        if name not in best or moved.chi2 < best[name].chi2:
            best[name] = moved
    return list(best.values())


def _is_elsewhere(found: Fitted, model: Fitted) -> bool:
    """Whether a fit has other parameters of the twin."""
    own = len(model.hypothesis.setting.uncertain)
    apart = np.abs(found.x[:own] - model.x[:own])
    return bool(np.any(apart > _ELSEWHERE * np.abs(model.x[:own])))


def go_where_led(case: Case, decision: Decision, fits: Sequence[Fitted]) -> bool:
    """Let the model go where a further effect has led it, if it needs none to stay there.

    A fit that stopped early goes on with nearly any effect beside it, which then has the credit.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        So far; its last round gets the better fit.
    fits : sequence of Fitted
        Of this round.

    Returns
    -------
    bool
        Whether it went: then the round has to begin again.
    """
    model = decision.model
    assert model is not None
    best = best_of(model, fits)
    if not decision.rounds or model.chi2 - best.chi2 <= needed_gain(decision):
        return False
    further = fitted_without_last(case.misfit, best)
    if further is None or model.chi2 - further.chi2 <= decision.threshold:
        return False
    *before, last = decision.rounds
    without = model_after(before, case.base)
    winner = evidence_of(case, without, further, decision.groups)
    again = (_moved(case, entry.fitted, further) for entry in last.rivals)
    others = [evidence_of(case, without, fitted, decision.groups) for fitted in again]
    rivals = tuple(rivals_of(winner, others))
    decision.rounds[-1] = replace(last, winner=winner, rivals=rivals)
    decision.model = further
    return True


def _moved(case: Case, rival: Fitted, further: Fitted) -> Fitted:
    """A rival's fit from where the model went, where it fits better there."""
    moved = fit(case.misfit, rival.hypothesis, further.parameters, near=rival, parallel=True)
    return rival if moved is None or moved.chi2 > rival.chi2 else moved


def accept(case: Case, decision: Decision, fits: list[Fitted], rng: np.random.Generator) -> bool:
    """Accept the simplest of the fitted effects that have shown to be at work.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget, which is widened to what the best first fit leaves.
    decision : Decision
        So far; gets one round more, or why there is none.
    fits : list of Fitted
        Of this round.
    rng : numpy Generator
        Source of the null draws.
    """
    assert decision.model is not None
    first = not decision.rounds
    if first:
        fits = _fits_by_measured_threshold(case, decision, fits, rng)
    evidence = sorted(
        (evidence_of(case, decision.model, fitted, decision.groups) for fitted in fits),
        key=lambda e: -e.gain,
    )
    needed = needed_gain(decision)
    proven = [e for e in evidence if is_proven(case, e, decision, needed)]
    if first and (disputed := _disputed(case, decision, evidence, proven, needed)):
        decision.disputed, decision.refused = disputed, evidence
        return False
    begun = [e for e in proven if begins_with_recordings(e)]
    proven = [e for e in proven if e not in begun]
    if begun and begun[0].gain > max((e.gain for e in proven), default=0.0) + decision.threshold:
        decision.unsettled = begun[0]
    accepted = [e for e in proven if is_large(case, e, needed)]
    small = [e for e in proven if e not in accepted]
    shadows = _in_shadow(decision, accepted, small)
    accepted = [e for e in accepted if e not in shadows]
    if not accepted:
        decision.refused = evidence
        if small and (shadows or not decision.rounds):
            decision.too_small = max(small, key=lambda e: e.gain)
        return False
    claimable = [e for e in accepted if e.name not in decision.silent]
    silent = [e for e in accepted if e.name in decision.silent]
    best_silent = max((e.gain for e in silent), default=-np.inf)
    if not claimable or best_silent > max(e.gain for e in claimable) - decision.threshold:
        decision.in_doubt = max(silent, key=lambda e: e.gain)
        return False
    slack = slack_of(case, decision, claimable)
    winner = _polished(case, decision, simplest(claimable, decision.threshold, slack))
    could = [e for e in evidence if e.name not in decision.silent and e not in begun]
    rivals = rivals_of(winner, could)
    margin = margin_over_limit(decision.threshold, slack)
    decision.rounds.append(Round(winner, tuple(rivals), tuple(evidence), needed, margin))
    decision.model = winner.fitted
    return True


def _in_shadow(
    decision: Decision, accepted: Sequence[Evidence], small: Sequence[Evidence]
) -> list[Evidence]:
    """Accepted effects that are part of a small one, or as likely that at the other end."""
    return [
        e
        for e in accepted
        if is_small_elsewhere(e, small) or any(is_shadow(decision, e, of) for of in small)
    ]


def _fits_by_measured_threshold(
    case: Case, decision: Decision, fits: list[Fitted], rng: np.random.Generator
) -> list[Fitted]:
    """Widen the budget to what the best first fit leaves, and set the threshold by null draws."""
    fits = widen_budget(case, decision, fits)
    nulls = NullGains(case.misfit, case.base, decision.tried, decision.groups)
    chance = gain_by_chance(case.misfit, best_of(case.base, fits), rng)
    decision.threshold = max(nulls.threshold(rng), chance)
    return fits


def _disputed(
    case: Case,
    decision: Decision,
    evidence: Sequence[Evidence],
    proven: Sequence[Evidence],
    needed: float,
) -> Evidence | None:
    """Effect that gains most and is yet disputed, where nothing that is proven comes near it."""
    least = _FAR_MORE * max((needed, *(e.gain for e in proven)))
    return next(
        (e for e in evidence if e.gain > least and is_disputed(case, e, decision.threshold)), None
    )


def _confirmed(
    case: Case, decision: Decision, screened: Sequence[Screened], chosen: Sequence[Candidate]
) -> list[Fitted]:
    """Fits of what is worth one; where they fall far short of what was promised, of the next too.

    A law that is almost right may be far off the straight line by which it was screened: an axis
    held by Coulomb friction stands still where one that creeps moves on.
    """
    model = decision.model
    assert model is not None
    fits = confirm(case.misfit, model, chosen)
    known = {c.effect for c in chosen}
    others = [s for s in screened if s.probe.candidate.effect not in known]
    if _fall_short(model, screened, fits):
        return fits + confirm(case.misfit, model, shortlist(others, _WORTH_FITTING))
    for family in sorted({c.law.family for c in chosen}):
        promised = [s for s in screened if s.probe.candidate.law.family == family]
        if _fall_short(model, promised, [f for f in fits if _family(f) == family]):
            relatives = [s for s in others if s.probe.candidate.law.family == family]
            fits += confirm(case.misfit, model, shortlist(relatives, _WORTH_FITTING))
    return fits


def _fall_short(model: Fitted, screened: Sequence[Screened], fits: Sequence[Fitted]) -> bool:
    promised = max((s.gain for s in screened if s.kept), default=0.0)
    kept = model.chi2 - min((f.chi2 for f in fits), default=model.chi2)
    return promised >= _PROMISING and kept <= _KEPT_PROMISE * promised


def _family(fitted: Fitted) -> str:
    return fitted.hypothesis.effects[-1].law.family


def _with_limits_scanned(
    case: Case,
    decision: Decision,
    tried: Sequence[Probe],
    chosen: Sequence[Candidate],
    rng: np.random.Generator,
) -> list[Candidate]:
    """What is worth a fit, limits beginning at the size that the recorded command tells."""
    assert decision.model is not None
    names = sorted({p.candidate.effect for p in tried})
    scanned = scan_limits(case, decision.model, rng, names, _WORTH_FITTING)
    found = [candidate for _, candidate in scanned]
    known = {candidate.effect for candidate in found}
    return [*(c for c in chosen if c.effect not in known), *found]


def _to_try(case: Case, model: Fitted) -> set[str]:
    """Families that are simulated at each start, as their slope about the model says little."""
    if chi2_per_dof(model, case.misfit) > _GROSS:
        return set(MISLED)
    families = {"limit"} if _is_uneven(model) else set()
    # A lag that inertia has made up for: from there its slope may point below zero.
    return families | {LAGS} if is_more_than_noise(case, model) else families


def _is_uneven(model: Fitted) -> bool:
    """Whether some stretch shows far more misfit than most, as a limit does that is rarely met."""
    means = [float(np.mean(block**2)) for block in model.residual]
    return max(means) > _UNEVEN * float(np.median(means))


def _polished(case: Case, decision: Decision, winner: Evidence) -> Evidence:
    """Fit once more from where the fit stopped: what it still leaves would look like physics."""
    fitted = winner.fitted
    again = fit(case.misfit, fitted.hypothesis, fitted.parameters, near=fitted, parallel=True)
    if again is None or again.chi2 >= winner.chi2:
        return winner
    assert decision.model is not None
    better = evidence_of(case, decision.model, again, decision.groups)
    return better if better.gain > winner.gain else winner


def with_limits(named: set[str]) -> set[str]:
    """Named effects, and those that are a limit of them or of which they are one."""
    taken = set(named)
    for name in named:
        taken |= set(CATALOGUE[name].contains)
    # Two laws that share a limit are one law twice.
    return taken | {name for name, law in CATALOGUE.items() if set(law.contains) & taken}
