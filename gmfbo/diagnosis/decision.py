"""Which effects are missing: screened, fitted, and decided on what the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case import Case, chi2_per_dof
from gmfbo.diagnosis.confirming import confirm, rough_worth_fitting, shortlist
from gmfbo.diagnosis.dispersion import dispersion_of
from gmfbo.diagnosis.fitting import Fitted, fit, stacked
from gmfbo.diagnosis.hypothesis import Candidate
from gmfbo.diagnosis.intervals import spread_of
from gmfbo.diagnosis.leaving_out import normal_equations
from gmfbo.diagnosis.left_out_runs import simulated_left_out, squares
from gmfbo.diagnosis.limit_scan import scan_limits
from gmfbo.diagnosis.misfit import Blocks, Misfit, chi2
from gmfbo.diagnosis.ranges import states_of
from gmfbo.diagnosis.rivals import rivals_of
from gmfbo.diagnosis.screening import Probe, Screened, probes, refined, screen
from gmfbo.diagnosis.threshold import NullGains, left_out_square

MOST_EFFECTS = 3
"""Effects that are named at most; recordings of a few seconds do not tell more apart."""

_NEXT_SHARE = 0.15  # of what is left beyond noise, which a further effect has to take away
_UNEXPLAINED_SHARE = 0.08  # of what no model explains, which the first effect has to take away
_FIRST_SHARE = 0.005  # of the first effect's gain: a law that is 7 % off leaves as much
_EACH_PARAMETER = 5.0  # gain that a further free parameter has to bring
_SEARCHED = 15.0  # the same for a line or an instant that was looked for in a few hundred places
_PLAIN_WORTH = 0.5  # thresholds that a larger law has to gain over its limit
_VAGUE_WORTH = 4.0  # the same where what sets it apart may as well be zero
_ALIKE = 0.3  # cosine of two effects' changes, above which the lesser is the other's shadow
_CLEAR, _SMALL = 10.0, 0.5  # times what is asked for: then this share of the floor will do
_BETWEEN_SHARE = 0.3  # of its gain, which a line has to keep where whole recordings are left out
_HARM_SHARE = 0.15  # of the gain, which a recording may lose
_LEAST_UNLIKE = 0.03  # of an effect's change that no parameter makes
_DOUBTFUL = 0.7  # of the gain on all; less on what was left out is checked by simulation
_UNEVEN = 1.4  # times the median stretch
_GROSS = 2.0  # chi2 per degree of freedom, above which refitted parameters mislead
_WORTH_FITTING = 8.0  # gain by screening below which no fit is tried


@dataclass(frozen=True, eq=False)
class Evidence:
    """An effect that was fitted, and what it gains on what the fit has not seen.

    Attributes
    ----------
    fitted : Fitted
        The model with the effect as its last.
    gains : ndarray, shape (n_groups,)
        Fall of chi2 in each group that was left out.
    signature : ndarray, shape (n_groups,)
        Square of the change that the effect makes in each group.
    chi2 : float
        Of the fit to all.
    """

    fitted: Fitted
    gains: NDArray[np.float64]
    signature: NDArray[np.float64]
    chi2: float

    @property
    def effect(self) -> Candidate:
        """The effect, at its fitted values."""
        return self.fitted.hypothesis.effects[-1]

    @property
    def name(self) -> str:
        """Its name in the catalogue."""
        return self.effect.effect

    @property
    def gain(self) -> float:
        """Fall of chi2 on what was left out, over all groups."""
        return float(self.gains.sum())


@dataclass(frozen=True, eq=False)
class Round:
    """One effect accepted, and what competed with it.

    Attributes
    ----------
    winner : Evidence
        What was accepted.
    rivals : tuple of Evidence
        Effects that explain the recordings as well.
    fitted : tuple of Evidence
        All effects that were fitted in this round.
    needed : float
        Gain that was asked for.
    margin : float
        Gain that a law has to have over its limit.
    """

    winner: Evidence
    rivals: tuple[Evidence, ...]
    fitted: tuple[Evidence, ...]
    needed: float
    margin: float


@dataclass(eq=False)
class Decision:
    """What was accepted, in the order of its discovery.

    Attributes
    ----------
    rounds : list of Round
        One for each accepted effect.
    model : Fitted
        The twin with all accepted effects.
    tried : list of Probe
        The whole library and its grids.
    like_parameters : dict of str to str
        Effects that were left out, and why: mostly a parameter of the twin does the same.
    screened : list of Screened
        What each probe explains of what the parameters leave.
    threshold : float
        Gain that chance gives once in a hundred times.
    groups : tuple of int
        Group of each window; whole groups are left out together.
    refused : list of Evidence
        Effects of the last round, of which none was accepted.
    dispersion : float
        chi2 per degree of freedom that the best model left by the budget alone, at least 1.
    left : float
        The same as it was: below 1 where the budget of noise is generous.
    silent : frozenset of str
        Effects that were not excited and cannot be named.
    in_doubt : Evidence or None
        One of them that explains as much as the best that could have been named.
    too_small : Evidence or None
        An effect below its floor that explains more than any that could have been named.
    """

    rounds: list[Round] = field(default_factory=list)
    model: Fitted | None = None
    tried: list[Probe] = field(default_factory=list)
    like_parameters: dict[str, str] = field(default_factory=dict)
    screened: list[Screened] = field(default_factory=list)
    threshold: float = np.inf
    groups: tuple[int, ...] = ()
    refused: list[Evidence] = field(default_factory=list)
    dispersion: float = 1.0
    left: float = np.inf
    silent: frozenset[str] = frozenset()
    in_doubt: Evidence | None = None
    too_small: Evidence | None = None


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
    decision.tried, decision.like_parameters = _apart_from_parameters(
        case, probes(case.misfit, case.base, candidates)
    )
    again = (progress, rng, look_again)
    _add_effects(case, decision, *again)
    if _take_back(case, decision):
        _add_effects(case, decision, *again)
    return decision


def _add_effects(
    case: Case,
    decision: Decision,
    progress: Callable[[str, float], None],
    rng: np.random.Generator,
    look_again: Callable[[Fitted], list[Candidate]],
) -> None:
    for number in range(len(decision.rounds), MOST_EFFECTS):
        progress(f"fitting effect {number + 1}", 0.4 + 0.15 * number)
        if number:
            assert decision.model is not None
            more = probes(case.misfit, decision.model, look_again(decision.model))
            decision.tried = [*decision.tried, *more]
        if not _next_round(case, decision, rng):
            return


def _take_back(case: Case, decision: Decision) -> bool:
    """Put a simpler or richer law in the first one's place where that is better beside the others.

    Alone, a law with more freedom makes up for effects that are only found after it, and what
    sets it apart from its limit may be hidden by them. What was found beside it is taken back.
    """
    if len(decision.rounds) < 2:
        return False
    assert decision.model is not None
    first, *others = decision.rounds
    named = {entry.winner.name for entry in others}
    limits = set(first.winner.effect.law.contains) - named
    others_of_it = [
        e
        for e in first.fitted
        if e.name in limits or first.winner.name in e.effect.law.contains
        if e.name not in decision.silent
    ]
    if not others_of_it:
        return False
    whole = decision.model.hypothesis
    beside = replace(whole, effects=whole.effects[1:])
    without = fit(case.misfit, beside, decision.model.parameters, parallel=True)
    if without is None:
        return False
    fits = confirm(case.misfit, without, [whole.effects[0], *(e.effect for e in others_of_it)])
    groups = decision.groups
    evidence = [_evidence(case, without, fitted, groups) for fitted in fits]
    needed = _needed(decision)
    proven = [
        e for e in evidence if _is_proven(case, e, decision, needed) and _is_large(case, e, needed)
    ]
    if not any(e.name == first.winner.name for e in proven):
        return False
    chosen = _simplest(proven, decision.threshold, 0.0)
    if chosen.name == first.winner.name:
        return False
    winner = next(e for e in others_of_it if e.name == chosen.name)
    rivals = rivals_of(winner, [e for e in first.fitted if e.name not in decision.silent])
    decision.rounds[:] = [replace(first, winner=winner, rivals=tuple(rivals))]
    decision.model = winner.fitted
    return True


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
    gross = chi2_per_dof(decision.model, case.misfit) > _GROSS
    if gross or _is_uneven(decision.model):
        rough = rough_worth_fitting(case.misfit, decision.model, tried, gross=gross)
        known = {c.effect for c in chosen}
        chosen += [c for c in rough if c.effect not in known][:3]
    chosen = _with_limits_scanned(case, decision, tried, chosen, rng)
    fits = confirm(case.misfit, decision.model, chosen)
    if first:
        fits = _widen_budget(case, decision, fits)
        nulls = NullGains(case.misfit, case.base, decision.tried, decision.groups)
        decision.threshold = nulls.threshold(rng)
    evidence = sorted(
        (_evidence(case, decision.model, fitted, decision.groups) for fitted in fits),
        key=lambda e: -e.gain,
    )
    needed = _needed(decision)
    proven = [e for e in evidence if _is_proven(case, e, decision, needed)]
    accepted = [e for e in proven if _is_large(case, e, needed)]
    small = [e for e in proven if e not in accepted]
    shadows = [e for e in accepted if any(_is_shadow(decision, e, of) for of in small)]
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
    # What the best law leaves beyond noise could as well be left by its limit.
    slack = _NEXT_SHARE * min(e.chi2 for e in claimable) * (1.0 - 1.0 / decision.dispersion)
    winner = _polished(case, decision, _simplest(claimable, decision.threshold, slack))
    rivals = rivals_of(winner, [e for e in evidence if e.name not in decision.silent])
    margin = max(slack, _PLAIN_WORTH * decision.threshold)
    decision.rounds.append(Round(winner, tuple(rivals), tuple(evidence), needed, margin))
    decision.model = winner.fitted
    return True


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


def _is_uneven(model: Fitted) -> bool:
    """Whether some stretch shows far more misfit than most, as a limit does that is rarely met."""
    means = [float(np.mean(block**2)) for block in model.residual]
    return max(means) > _UNEVEN * float(np.median(means))


def _polished(case: Case, decision: Decision, winner: Evidence) -> Evidence:
    """Fit once more from where the fit stopped: what it still leaves would look like physics."""
    again = fit(case.misfit, winner.fitted.hypothesis, winner.fitted.parameters, parallel=True)
    if again is None or again.chi2 >= winner.chi2:
        return winner
    assert decision.model is not None
    better = _evidence(case, decision.model, again, decision.groups)
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
    best = min([case.base, *fits], key=lambda f: f.chi2)
    if best is not case.base:
        # A fit that stopped early would pass for a law that is not exact.
        again = fit(case.misfit, best.hypothesis, best.parameters, parallel=True)
        if again is not None and again.chi2 < best.chi2:
            fits = [again if f is best else f for f in fits]
            best = again
    left = _beyond_library(case.misfit, best, decision.tried)
    dof = sum(block.size for block in left)
    decision.left = chi2(left) / dof
    decision.dispersion = max(1.0, decision.left)
    spread = dispersion_of(replace(best, residual=left), case.misfit.whiteners)
    wider = case.misfit.with_whiteners(case.budget.whiteners(spread))
    case.use(wider)
    decision.model = case.base
    return [f.measured_by(wider) for f in fits]


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


def _evidence(case: Case, model: Fitted, fitted: Fitted, groups: Sequence[int]) -> Evidence:
    before, after = squares(model.residual, groups), squares(fitted.residual, groups)
    inside = before - after
    outside = left_out_square(model, groups) - left_out_square(fitted, groups)
    if outside.sum() < _DOUBTFUL * inside.sum():
        # Sensitivities of a gap or a limit may be rough: let the FMU tell.
        simulated = simulated_left_out(case.misfit, model, groups) - simulated_left_out(
            case.misfit, fitted, groups
        )
        # A limit that one stretch alone shows is unbound by the others: the better tells.
        is_limit = fitted.hypothesis.effects[-1].law.family == "limit"
        if not (is_limit and outside.sum() > simulated.sum()):
            outside = simulated
    gains = outside if outside.sum() < inside.sum() else inside
    signature = squares(
        tuple(a - b for a, b in zip(model.residual, fitted.residual, strict=True)), groups
    )
    return Evidence(fitted, gains, signature, fitted.chi2)


def _needed(decision: Decision) -> float:
    """What the next effect has to gain: more where the model is known to be imperfect."""
    assert decision.model is not None
    if not decision.rounds:
        # Where even the best model leaves more than noise, that may look like an effect as well.
        dof = sum(r.size for r in decision.model.residual)
        return max(decision.threshold, _UNEXPLAINED_SHARE * dof * (1.0 - 1.0 / decision.dispersion))
    beyond_noise = decision.model.chi2 * (1.0 - 1.0 / decision.dispersion)
    first = decision.rounds[0].winner.gain
    further = (1 + len(decision.rounds)) * decision.threshold
    return max(further, _NEXT_SHARE * beyond_noise, _FIRST_SHARE * first)


def _is_shadow(decision: Decision, evidence: Evidence, of: Evidence) -> bool:
    """Whether an effect does part of what another one does better."""
    if of.gain <= evidence.gain + decision.threshold:
        return False
    assert decision.model is not None
    product, one, other = 0.0, 0.0, 0.0
    residuals = (decision.model.residual, evidence.fitted.residual, of.fitted.residual)
    for before, with_it, with_other in zip(*residuals, strict=True):
        product += float(np.sum((before - with_it) * (before - with_other)))
        one += float(np.sum((before - with_it) ** 2))
        other += float(np.sum((before - with_other) ** 2))
    return product > _ALIKE * float(np.sqrt(one * other))


def _is_large(case: Case, evidence: Evidence, needed: float) -> bool:
    """Whether somebody would act on an effect of this size."""
    law, excitation = evidence.effect.law, case.setting.excitation
    values = {**evidence.effect.more, **evidence.effect.values}
    share = _SMALL if evidence.gain > _CLEAR * needed else 1.0
    return law.size(values, excitation) >= share * law.floor(excitation)


def _is_proven(case: Case, evidence: Evidence, decision: Decision, needed: float) -> bool:
    """Whether an effect, of whatever size, is at work beyond chance."""
    if evidence.gain <= needed + _freedom(evidence.effect):
        return False
    by_record = np.bincount([w.record for w in case.budget.windows], evidence.gains)
    if np.any(by_record < -max(0.8 * decision.threshold, _HARM_SHARE * evidence.gain)):
        return False
    if not _holds_between_recordings(case, evidence, decision):
        return False
    return _acts_long_enough(case, evidence)


def _holds_between_recordings(case: Case, evidence: Evidence, decision: Decision) -> bool:
    """Whether a line that others show is there in each recording: a drift looks like one.

    Stretches of one recording share its drift, so that leaving out one of them is not enough.
    """
    records = [w.record for w in case.budget.windows]
    if not evidence.effect.law.is_line or len(set(records)) < 2:
        return True
    assert decision.model is not None
    outside = left_out_square(decision.model, records) - left_out_square(evidence.fitted, records)
    return float(outside.sum()) > _BETWEEN_SHARE * evidence.gain


def _freedom(effect: Candidate) -> float:
    """What an effect gains by chance beyond one of a single size, and by having been searched."""
    return _EACH_PARAMETER * (len(effect.parameters) - 1) + _SEARCHED * effect.searched


def _acts_long_enough(case: Case, evidence: Evidence) -> bool:
    least = evidence.effect.law.least_time
    if not least:
        return True
    total = 0.0
    values = {**evidence.effect.more, **evidence.effect.values}
    for record, run in zip(case.simulations.records, evidence.fitted.simulated, strict=True):
        states = states_of(run, record)
        total += states.step * float(np.count_nonzero(evidence.effect.law.acts(states, values)))
    return total >= least


def _may_vanish(evidence: Evidence, simpler: str) -> bool:
    """Whether the values that set an effect apart from a simpler one may as well be zero."""
    fitted, law = evidence.fitted, evidence.effect.law
    apart = law.vanishing.get(simpler, ())
    spread = spread_of(fitted, np.random.default_rng(0))
    place = fitted.x.size - len(evidence.effect.parameters)
    rows = [i for i, p in enumerate(evidence.effect.parameters, start=place) if p.name in apart]
    return bool(rows) and all(spread.low[i] < 0.0 < spread.high[i] for i in rows)


def _worth(larger: Evidence, simpler: str) -> float:
    return _VAGUE_WORTH if _may_vanish(larger, simpler) else _PLAIN_WORTH


def _simplest(accepted: Sequence[Evidence], threshold: float, slack: float) -> Evidence:
    """The best, or its simplest limit over which it does not gain the threshold or the slack."""
    best = max(accepted, key=lambda e: e.gain - _freedom(e.effect))
    while True:
        simpler = [
            e
            for e in accepted
            if e.name in best.effect.law.contains
            and e.gain > best.gain - max(slack, threshold * _worth(best, e.name))
        ]
        if not simpler:
            return best
        best = max(simpler, key=lambda e: e.gain)
