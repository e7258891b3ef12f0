"""Decide which effects are missing: screened, fitted, and held to what the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.acceptance import (
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
from gmfbo.diagnosis.begun_at_rest import begun_better, screen_both_starts
from gmfbo.diagnosis.case import Case, chi2_per_dof, is_more_than_noise
from gmfbo.diagnosis.confirming import LAGS, MISLED, confirm, rough_worth_fitting, shortlist
from gmfbo.diagnosis.decision import Decision, Evidence, Round
from gmfbo.diagnosis.dispersion import dispersion_of
from gmfbo.diagnosis.exchange import exchange_first
from gmfbo.diagnosis.fitting import Fitted, fit, stacked
from gmfbo.diagnosis.gain_by_chance import gain_by_chance
from gmfbo.diagnosis.hypothesis import Candidate
from gmfbo.diagnosis.leaving_out import normal_equations
from gmfbo.diagnosis.left_out_gain import evidence_of
from gmfbo.diagnosis.limit_scan import scan_limits
from gmfbo.diagnosis.misfit import Blocks, Misfit, chi2
from gmfbo.diagnosis.rivals import rivals_beside, rivals_of
from gmfbo.diagnosis.screening import Probe, Screened, probes, refined, screen
from gmfbo.diagnosis.threshold import NullGains

MOST_EFFECTS = 3
"""Effects that are named at most; recordings of a few seconds do not tell more apart."""

_LEAST_UNLIKE = 0.03  # of an effect's change that no parameter makes
_UNEVEN = 1.4  # times the median stretch
_GROSS = 2.0  # chi2 per degree of freedom, above which refitted parameters mislead
_FAR_MORE = 2.0  # times the gain of what is proven, or of what is asked for
_WORTH_FITTING = 8.0  # gain by screening below which no fit is tried
_PROMISING = 200.0  # gain by screening from which it is asked whether fits keep what it promised
_KEPT_PROMISE = 0.25  # of it, below which what it ranked next is fitted too


def decide(
    case: Case,
    candidates: Sequence[Candidate],
    rng: np.random.Generator,
    progress: Callable[[str, float], None],
    *,
    silent: Collection[str] = (),
    look_again: Callable[[Fitted], list[Candidate]] = lambda model: [],
) -> Decision:
    """Accept effects one after the other, until none gains enough.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget; its budget is widened to what the best model leaves.
    candidates : sequence of Candidate
        The library: every start of every effect that can be tested.
    rng : numpy Generator
        Source of the null draws.
    progress : callable
        Told the stage and the share that is done.
    silent : collection of str
        Effects among them that the recordings do not excite: they are never named, but where one
        explains as much as the best, nothing is.
    look_again : callable
        Further starts about a model with named effects: lines and pulses that those had hidden.
    """
    decision = Decision(model=case.base, groups=groups_of(case), silent=frozenset(silent))
    progress("screening the library", 0.2)
    screen_both_starts(case, case.base, candidates, decision.groups)
    decision.tried, decision.like_parameters = _apart_from_parameters(
        case, probes(case.misfit, case.base, candidates)
    )

    def go_on(so_far: Decision) -> None:
        _add_effects(case, so_far, candidates, progress, rng, look_again)

    go_on(decision)
    if exchange_first(case, decision, needed_gain(decision)):
        go_on(decision)
    elif len(decision.rounds) == 1:
        decision = _as_pair(case, decision, go_on)
    _judge_early_rivals(case, decision)
    return decision


def _judge_early_rivals(case: Case, decision: Decision) -> None:
    """What was found later tells many a rival from the effect that came first."""
    assert decision.model is not None
    for place, entry in enumerate(decision.rounds[:-1]):
        kept = rivals_beside(case, decision.model, place, entry.rivals)
        decision.rounds[place] = replace(entry, rivals=kept)


def _as_pair(case: Case, decision: Decision, go_on: Callable[[Decision], None]) -> Decision:
    """Two effects in the place of one that does most of what both do, where they do it better.

    Friction that differs by direction is Coulomb friction with a constant torque, wherever the axis
    slides: what a spring does beside that is then too little to be named.
    """
    pair = replace(decision, rounds=list(decision.rounds))
    if not exchange_first(case, pair, decision.threshold):
        return decision
    go_on(pair)
    assert decision.model is not None
    assert pair.model is not None
    alone = decision.model.measured_by(case.misfit)
    if len(pair.rounds) > 1 and pair.model.chi2 < alone.chi2 - decision.threshold:
        return pair
    decision.model = alone
    decision.rounds[:] = [entry.measured_by(case.misfit) for entry in decision.rounds]
    return decision


def _add_effects(
    case: Case,
    decision: Decision,
    library: Sequence[Candidate],
    progress: Callable[[str, float], None],
    rng: np.random.Generator,
    look_again: Callable[[Fitted], list[Candidate]],
) -> None:
    for number in range(len(decision.rounds), MOST_EFFECTS):
        progress(f"fitting effect {number + 1}", 0.4 + 0.15 * number)
        if number:
            assert decision.model is not None
            more = look_again(decision.model)
            if is_more_than_noise(case, decision.model):
                # About a model that is far from the first one, effects look otherwise.
                testable = [c for c in library if c.effect not in decision.like_parameters]
                decision.tried = probes(case.misfit, decision.model, [*testable, *more])
                _narrow_budget(case, decision)
            else:
                decision.tried = [*decision.tried, *probes(case.misfit, decision.model, more)]
        if not _next_round(case, decision, rng):
            return


def _apart_from_parameters(
    case: Case, tried: Sequence[Probe]
) -> tuple[list[Probe], dict[str, str]]:
    """Leave out effects that the refitted parameters can make by themselves."""
    one_group = [0] * len(case.budget.windows)
    most: dict[str, float] = {}
    for entry in screen(case.misfit, case.base, tried, one_group):
        name = entry.probe.candidate.effect
        most[name] = max(most.get(name, 0.0), entry.unlike_parameters)
    alike = {
        p.candidate.effect: _nearest_parameter(case, p)
        for p in tried
        if most.get(p.candidate.effect, 1.0) < _LEAST_UNLIKE
    }
    return [p for p in tried if p.candidate.effect not in alike], alike


def _nearest_parameter(case: Case, probe: Probe) -> str:
    """Why an effect is left out: the parameter whose sensitivity is most parallel to its change."""
    columns = stacked(case.misfit, probe.columns[:1])
    if not case.base.x.size or not any(np.any(change) for change in columns):
        return "changes nothing in these recordings"
    cosines = np.zeros(case.base.x.size)
    for own, change in zip(case.base.sensitivity, columns, strict=True):
        cosines += own @ change[0]
    sizes = np.sqrt(sum(np.sum(own**2, axis=1) for own in case.base.sensitivity))
    nearest = int(np.argmax(np.abs(cosines) / np.maximum(sizes, 1e-300)))
    return f"is parameter {case.setting.uncertain[nearest].name}"


def groups_of(case: Case) -> tuple[int, ...]:
    """Each stretch of a recording is left out by itself.

    Without one of four recordings, parameters and effects extrapolate so far that chance alone
    gives gains of a hundred; without one of eight stretches, of ten.
    """
    return tuple(range(len(case.budget.windows)))


def _next_round(case: Case, decision: Decision, rng: np.random.Generator) -> bool:
    assert decision.model is not None
    named = {c.effect for c in decision.model.hypothesis.effects}
    tried = [p for p in decision.tried if p.candidate.effect not in _with_limits(named)]
    screened = screen(case.misfit, decision.model, tried, decision.groups)
    if screened and screened[0].gain > _WORTH_FITTING:
        screened = refined(case.misfit, decision.model, screened, decision.groups)
    first = not decision.rounds
    if first:
        decision.screened = screened
    chosen = shortlist(screened, _WORTH_FITTING)
    families = _to_try(case, decision.model)
    known = {c.effect for c in chosen}
    chosen += rough_worth_fitting(case.misfit, decision.model, tried, families, known)
    chosen = _with_limits_scanned(case, decision, tried, chosen, rng)
    fits = _confirmed(case, decision, screened, chosen)
    decision.model, fits = begun_better(case, decision.model, fits)
    if first:
        fits = _widen_budget(case, decision, fits)
        nulls = NullGains(case.misfit, case.base, decision.tried, decision.groups)
        chance = gain_by_chance(case.misfit, _best(case, fits), rng)
        decision.threshold = max(nulls.threshold(rng), chance)
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
    shadows = [
        e
        for e in accepted
        if is_small_elsewhere(e, small) or any(is_shadow(decision, e, of) for of in small)
    ]
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


def _with_limits(named: set[str]) -> set[str]:
    """Named effects, and those that are a limit of them or of which they are one."""
    from gmfbo.physics import CATALOGUE

    taken = set(named)
    for name in named:
        taken |= set(CATALOGUE[name].contains)
    # Two laws that share a limit are one law twice.
    return taken | {name for name, law in CATALOGUE.items() if set(law.contains) & taken}


def _widen_budget(case: Case, decision: Decision, fits: list[Fitted]) -> list[Fitted]:
    """Measure by what the whole library together leaves: a gain counts relative to that."""
    best = _best(case, fits)
    if best is not case.base:
        # A fit that stopped early would pass for a law that is not exact.
        again = fit(case.misfit, best.hypothesis, best.parameters, near=best, parallel=True)
        if again is not None and again.chi2 < best.chi2:
            fits = [again if f is best else f for f in fits]
            best = again
    left = _beyond_library(case.misfit, best, decision.tried)
    _measure_by(case, decision, case.misfit, best, left)
    decision.model = case.base
    return [f.measured_by(case.misfit) for f in fits]


def _best(case: Case, fits: Sequence[Fitted]) -> Fitted:
    return min([case.base, *fits], key=lambda f: f.chi2)


def _narrow_budget(case: Case, decision: Decision) -> None:
    """Measure by what the library leaves beside named effects, where that is less than before."""
    assert decision.model is not None
    plain = case.plain
    model = decision.model.measured_by(plain)
    left = _beyond_library(plain, model, decision.tried)
    if chi2(left) < decision.left * sum(block.size for block in left):
        _measure_by(case, decision, plain, model, left)
        decision.model = model.measured_by(case.misfit)
        decision.rounds[:] = [entry.measured_by(case.misfit) for entry in decision.rounds]
        if decision.beside_rest is not None:
            decision.beside_rest = decision.beside_rest.measured_by(case.misfit)


def _measure_by(case: Case, decision: Decision, plain: Misfit, best: Fitted, left: Blocks) -> None:
    """Let the case be measured by what is left, in place of noise alone."""
    decision.left = chi2(left) / sum(block.size for block in left)
    decision.dispersion = max(1.0, decision.left)
    spread = dispersion_of(replace(best, residual=left), plain.whiteners)
    case.use(plain.with_whiteners(case.budget.whiteners(spread)))


def _beyond_library(misfit: Misfit, best: Fitted, tried: Sequence[Probe]) -> Blocks:
    """Residual of the best model after a linear fit of every probe at once.

    What a second effect would explain must not count as noise against it.
    """
    together = best.sensitivity
    for probe in tried:
        more = stacked(misfit, probe.columns)
        together = tuple(np.concatenate([a, b]) for a, b in zip(together, more, strict=True))
    precision = np.concatenate([best.prior, *(probe.prior for probe in tried)])
    one_group = [0] * len(best.residual)
    solution = normal_equations(best.residual, together, one_group, precision).solution()
    return tuple(r - solution @ a for r, a in zip(best.residual, together, strict=True))
