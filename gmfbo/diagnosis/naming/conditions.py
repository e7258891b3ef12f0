"""What an effect has to show to be named: gain, size, and no simpler law that does as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case, times_noise
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.intervals import spread_of
from gmfbo.diagnosis.naming.candidate_fits import LIMIT
from gmfbo.diagnosis.naming.decision import Decision, Evidence
from gmfbo.diagnosis.naming.rivals import AS_GOOD
from gmfbo.diagnosis.naming.threshold import left_out_square
from gmfbo.diagnosis.naming.time_at_work import seconds_at_work
from gmfbo.diagnosis.runs.measured_excitation import states_of

_NEXT_SHARE = 0.15  # of what is left beyond noise, which a further effect has to take away
_UNEXPLAINED_SHARE = 0.08  # of what no model explains, which the first effect has to take away
_PULSE_SHARE = 0.5  # the same of a pulse in one recording, of all that is more than noise
_FIRST_SHARE = 0.005  # of the first effect's gain: a law that is 7 % off leaves as much
_EACH_PARAMETER = 5.0  # gain that a further free parameter has to bring
_SEARCHED = 15.0  # the same for a line or an instant that was looked for in a few hundred places
_PLAIN_WORTH = 0.5  # thresholds that a larger law has to gain over its limit
_VAGUE_WORTH = 4.0  # the same where what sets it apart may as well be zero
_ALIKE = 0.3  # cosine of two effects' changes, above which the lesser is the other's shadow
_CLEAR, _SMALL = 5.0, 0.5  # times what is asked for: then this share of a floor will do
_NO_CHANCE = 0.9  # of the gain of what passed once, which a law without a clock explains
_SEEN = 2.0  # the same of friction and play, whose floors are no tolerance of twins
_BETWEEN_SHARE = 0.3  # of its gain, which a line has to keep where whole recordings are left out
_HARM_SHARE = 0.15  # of the gain, which recordings may lose together
_LASTING = 0.2  # of the gain of an offset, which it has after the first stretches of recordings


MECHANICS = frozenset({"friction", "spring"})
"""Families of effects whose least sizes are no tolerance of twins."""


def needed_gain(decision: Decision) -> float:
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


def slack_of(case: Case, decision: Decision, accepted: Sequence[Evidence]) -> float:
    """What the best law leaves beyond noise: its limit could as well leave that."""
    best = min(accepted, key=lambda e: e.chi2)
    times = times_noise(case, best.fitted)
    return _NEXT_SHARE * best.chi2 * (1.0 - 1.0 / max(times, decision.dispersion))


def margin_over_limit(threshold: float, slack: float) -> float:
    """Gain that a law has to have over its limit, where what sets it apart is no zero.

    Parameters
    ----------
    threshold, slack : float
        As of `simplest`.
    """
    return max(slack, _PLAIN_WORTH * threshold)


def is_shadow(decision: Decision, evidence: Evidence, of: Evidence) -> bool:
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


def is_small_elsewhere(evidence: Evidence, small: Sequence[Evidence]) -> bool:
    """Whether the same at the other end of the loop is what rigs are off by, and as likely.

    Parameters
    ----------
    evidence : Evidence
        The effect.
    small : sequence of Evidence
        Effects at work that nobody would act on.
    """
    elsewhere = [e for e in small if e.name in evidence.effect.law.same_loop]
    return any(e.gain > AS_GOOD * evidence.gain for e in elsewhere)


def is_large(case: Case, evidence: Evidence, needed: float) -> bool:
    """Whether somebody would act on an effect of this size."""
    law, excitation = evidence.effect.law, case.setting.excitation
    values = {**evidence.effect.more, **evidence.effect.values}
    # What is cut off a command is more than the twin would have asked for without the limit.
    runs = zip(evidence.fitted.simulated, case.simulations.records, strict=True)
    asked_for = max(float(np.abs(states_of(run, record).command).max()) for run, record in runs)
    size = law.size(values, replace(excitation, command=asked_for))
    return size >= _asked(evidence, needed) * law.floor(excitation)


def _asked(evidence: Evidence, needed: float) -> float:
    """Share of the least size and of the least time that will do."""
    clear = _SEEN if evidence.effect.law.family in MECHANICS else _CLEAR
    return _SMALL if evidence.gain > clear * needed else 1.0


def is_proven(case: Case, evidence: Evidence, decision: Decision, needed: float) -> bool:
    """Whether an effect, of whatever size, is at work beyond chance."""
    if evidence.gain <= needed + _freedom(evidence.effect):
        return False
    if is_disputed(case, evidence, decision.threshold):
        return False
    if not _holds_between_recordings(case, evidence, decision):
        return False
    if _is_where_friction_held(case, evidence, decision):
        return False
    if _passes_amid_misfit(evidence, decision):
        return False
    return _acts_long_enough(case, evidence, needed)


def is_disputed(case: Case, evidence: Evidence, threshold: float) -> bool:
    """Whether some recordings speak against what others show, each by a fit to the rest.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    evidence : Evidence
        The effect.
    threshold : float
        Gain that chance does not give.
    """
    by_record = np.bincount([w.record for w in case.budget.windows], evidence.gains)
    harm = -float(by_record[by_record < 0.0].sum())
    return harm > max(0.8 * threshold, _HARM_SHARE * evidence.gain)


def begins_with_recordings(evidence: Evidence) -> bool:
    """Whether what passes may have been there before the first row: the axis was not at rest."""
    names = [p.name for p in evidence.effect.parameters]
    if "start" not in names:
        return False
    low = spread_of(evidence.fitted, np.random.default_rng(0)).low
    return bool(low[len(low) - len(names) + names.index("start")] <= 0.0)


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


def _passes_amid_misfit(evidence: Evidence, decision: Decision) -> bool:
    """Whether a pulse is where a named law that is not right happens to leave most.

    What passes once explains the stretch that it was looked for in, whatever is wrong there.
    """
    if not decision.rounds or evidence.effect.only is None:
        return False
    assert decision.model is not None
    noise = sum(block.size for block in decision.model.residual) / decision.dispersion
    return evidence.gain < _PULSE_SHARE * (decision.model.chi2 - noise)


def _is_where_friction_held(case: Case, evidence: Evidence, decision: Decision) -> bool:
    """Whether an offset of the sensor shows only in how recordings begin, beside friction.

    Within friction an axis rests where it was left, and no recording tells where that was.
    """
    assert decision.model is not None
    beside = {c.law.family for c in decision.model.hypothesis.effects}
    if evidence.name != "sensor_offset" or "friction" not in beside:
        return False
    records = [w.record for w in case.budget.windows]
    begins = [k == 0 or record != records[k - 1] for k, record in enumerate(records)]
    later = np.asarray(evidence.signature)[~np.array(begins)]
    return later.size > 0 and float(later.sum()) < _LASTING * float(np.sum(evidence.signature))


def _freedom(effect: Candidate) -> float:
    """What an effect gains by chance beyond one of a single size, and by having been searched."""
    return _EACH_PARAMETER * (len(effect.parameters) - 1) + _SEARCHED * effect.searched


def _acts_long_enough(case: Case, evidence: Evidence, needed: float) -> bool:
    least = _asked(evidence, needed) * evidence.effect.law.least_time
    if not least:
        return True
    records = case.simulations.records
    return seconds_at_work(evidence.effect, evidence.fitted.simulated, records) >= least


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


def simplest(accepted: Sequence[Evidence], threshold: float, slack: float) -> Evidence:
    """The best, or its simplest limit over which it does not gain the threshold or the slack.

    A push at some time makes up for whatever happens once. That it comes just where a law without
    a clock would act is no chance: a law that explains nearly as much is preferred.

    Parameters
    ----------
    accepted : sequence of Evidence
        Effects that could be named.
    threshold : float
        Gain that chance does not give.
    slack : float
        See `slack_of`.
    """
    best = max(accepted, key=lambda e: e.gain - _freedom(e.effect))
    if best.effect.law.family == LIMIT:
        # Where one stretch alone shows a limit, the others do not know it: its gain is too small.
        limits = [e for e in accepted if e.effect.law.family == LIMIT]
        best = min(limits, key=lambda e: e.chi2 + _freedom(e.effect))
    elif best.effect.law.is_passing:
        lasting = [e for e in accepted if not e.effect.law.is_passing]
        nearly = [e for e in lasting if e.gain > _NO_CHANCE * best.gain]
        best = max(nearly, key=lambda e: e.gain, default=best)
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
