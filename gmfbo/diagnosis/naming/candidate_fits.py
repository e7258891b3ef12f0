"""The most promising effects fitted through the FMU, everything free."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2
from gmfbo.diagnosis.naming.time_at_work import seconds_at_work
from gmfbo.diagnosis.noise.replayed_noise import under_noise
from gmfbo.diagnosis.screening.probes import Probe, Screened
from gmfbo.diagnosis.screening.trials import least_square, trials_of, with_effect
from gmfbo.physics import CATALOGUE
from gmfbo.physics.harmonic import strongest_first

MOST = 6
"""Effects that are fitted in one round."""

_LEAST_SHARE = 0.02  # of the best gain: less is no rival
_WORTH_NOISE = 50.0  # gain from which it is asked whether noise shakes the axis
_WORTH_OTHERS = 15.0  # gain from which other values of what is not fitted are tried
_NEAR = 0.5  # of the best gain, from which the same is asked
_MOST_ROUGH = 3  # effects that are fitted beside those that screening asks for
_OTHER_LAGS = (0.7, 0.8, 0.9, 0.95, 1.05, 1.2)  # times a lag at which its fit may start too
_SHORTEST = 3  # starts of a lag: no parameter hides a long one
_A_FEW = 4  # steps that show whether a start leads anywhere
_AGAIN = 4  # points that are tried after that
_ROUGH = ("limit", "inertia", "spring", "gain")  # families with many minima

LIMIT = "limit"
"""Family of what is only met now and then: noise bridges it, or reaches it by itself."""

LAGS = "timing"
"""Family of delay, actuator lag and sensor lag."""

MISLED = (*_ROUGH, LAGS)
"""Families that refitted parameters hide where they have swallowed part of them."""


def shortlist(screened: Sequence[Screened], least_gain: float) -> list[Candidate]:
    """Effects worth a fit: the best start of each, their simpler limits, one a family.

    Parameters
    ----------
    screened : sequence of Screened
        Best first.
    least_gain : float
        Gain below which an effect is not worth a fit.
    """
    best: dict[str, Screened] = {}
    for entry in screened:
        best.setdefault(entry.probe.candidate.effect, entry)
    worth = [s for s in best.values() if s.gain > least_gain and s.kept]
    if not worth:
        return []
    chosen = [s for s in worth[:4] if s.gain > _LEAST_SHARE * worth[0].gain]
    families = {s.probe.candidate.law.family for s in chosen}
    for entry in worth:
        family = entry.probe.candidate.law.family
        if family not in families and len(chosen) < MOST and entry.gain > 0.1 * worth[0].gain:
            chosen.append(entry)
            families.add(family)
    names = {s.probe.candidate.effect for s in chosen}
    first = worth[0].probe.candidate.law
    alike = [n for n in first.confused_with if CATALOGUE[n].family == first.family == "friction"]
    for entry in list(chosen):
        law = entry.probe.candidate.law
        nearby = [*law.contains, *(alike if law is first else ())]
        # The same at the other end of the loop is a rival, however little its own start explains.
        wanted = [*(n for n in nearby if n in best and best[n].kept), *law.same_loop]
        for name in wanted:
            if name in best and name not in names:
                chosen.append(best[name])
                names.add(name)
    return [start_of(entry) for entry in chosen]


def start_of(entry: Screened) -> Candidate:
    """Effect at the amplitudes that screening found, where its fit begins."""
    candidate = entry.probe.scaled(entry.shares)
    law = candidate.law
    values = {}
    for name, value in candidate.values.items():
        start = entry.probe.candidate.values[name]
        values[name] = value if value else 0.1 * start
    if law.is_line:
        values = strongest_first(values)
    return Candidate(law.name, values, candidate.more, candidate.only)


def confirm(
    misfit: Misfit,
    base: Fitted,
    candidates: Sequence[Candidate],
) -> list[Fitted]:
    """Fit each candidate added to a model, several at a time.

    Those that cannot run are left out, and those that have become something else than their name.
    """

    def one(candidate: Candidate) -> Fitted | None:
        starts = _best_starts(misfit, base, candidate)
        fits = [fit(misfit, joined, parameters, near=base) for joined, parameters in starts]
        found = min((f for f in fits if f is not None), key=lambda f: f.chi2, default=None)
        return None if found is None else _otherwise(misfit, base, found)

    def again(found: Fitted) -> Fitted:
        law = found.hypothesis.effects[-1].law
        needs_noise = law.family == LIMIT or law.name == "backlash"
        if base.chi2 - found.chi2 < least and not needs_noise:
            return found
        noisy = under_noise(misfit, found)
        if noisy is None:
            return found
        moved = fit(misfit, noisy, found.parameters, near=found, iterations=_AGAIN)
        return found if moved is None or moved.chi2 > found.chi2 else moved

    fits = [f for f in misfit.simulations.map_outer(one, candidates) if f is not None]
    best = max((base.chi2 - f.chi2 for f in fits), default=0.0)
    least = max(_WORTH_NOISE, _NEAR * best)
    return [f for f in misfit.simulations.map_outer(again, fits) if _is_itself(f)]


def _is_itself(fitted: Fitted) -> bool:
    effect = fitted.hypothesis.effects[-1]
    return effect.law.is_itself(effect.values, fitted.hypothesis.setting.excitation)


def _best_starts(
    misfit: Misfit, base: Fitted, candidate: Candidate
) -> list[tuple[Hypothesis, Mapping[str, float]]]:
    """The best of several points to begin at, since gaps and limits have many minima.

    Two of a limit where the one that explains most as it is, is not the one of which a linear step
    promises most: behind a limit, such a step may lead anywhere.
    """
    starts = [candidate]
    if candidate.law.family in _ROUGH:
        excitation = base.hypothesis.setting.excitation
        starts += [candidate.with_values(values) for values in candidate.law.starts(excitation)]
    if candidate.law.family == LAGS and base.hypothesis.setting.is_rough:
        # Where steps are wide, a fit that starts beyond the minimum may not come back.
        starts += [
            candidate.with_values({n: share * v for n, v in candidate.values.items()})
            for share in _OTHER_LAGS
        ]
    trials = [trial for start in starts for trial in trials_of(misfit, base, start)]
    # Where nothing acts, there is no slope that could lead a fit away.
    records = misfit.simulations.records
    acting = [t for t in trials if seconds_at_work(t.candidate, t.simulated, records)]
    if not trials:
        return [(with_effect(base.hypothesis, candidate), base.parameters)]
    promising = min(acting or trials, key=lambda t: t.square)
    best = [promising]
    if candidate.law.family == LIMIT:
        nearest = min(acting or trials, key=lambda t: chi2(misfit.residual(t.simulated)))
        best += [] if nearest is promising else [nearest]
    return [(trial.hypothesis, trial.parameters) for trial in best]


def _otherwise(misfit: Misfit, base: Fitted, found: Fitted) -> Fitted:
    """The same with other values of what is not fitted, as long as they explain more."""
    if base.chi2 - found.chi2 < _WORTH_OTHERS:
        return found
    law, excitation = found.hypothesis.effects[-1].law, found.hypothesis.setting.excitation
    for values in law.fixed_otherwise(excitation):
        *others, candidate = found.hypothesis.effects
        changed = replace(candidate, more={**candidate.more, **values})
        hypothesis = replace(found.hypothesis, effects=(*others, changed))
        moved = fit(misfit, hypothesis, found.parameters, near=found, iterations=_AGAIN)
        if moved is None or moved.chi2 > found.chi2:
            break
        found = moved
    return found


def rough_worth_fitting(
    misfit: Misfit,
    base: Fitted,
    tried: Sequence[Probe],
    families: Collection[str],
    beside: Collection[str],
) -> list[Candidate]:
    """Effects that explain more under other parameters than those refitted without them.

    Parameters
    ----------
    misfit : Misfit
        Recordings and simulators.
    base : Fitted
        The model so far.
    tried : sequence of Probe
        The library.
    families : collection of str
        Which families of it are tried.
    beside : collection of str
        Effects that are fitted in any case.
    """
    shapes = [p.candidate for p in tried if p.candidate.law.family in families]

    def one(candidate: Candidate) -> tuple[float, Candidate]:
        return least_square(misfit, base, candidate), candidate

    best: dict[str, tuple[float, Candidate]] = {}
    for square, candidate in misfit.simulations.map_outer(one, shapes):
        if square < best.get(candidate.effect, (np.inf,))[0]:
            best[candidate.effect] = square, candidate
    ranked = sorted(best.values(), key=lambda entry: entry[0])
    others = [(square, c) for square, c in ranked if c.effect not in beside]
    chosen = [candidate for square, candidate in others if square < base.chi2][:_MOST_ROUGH]
    fitted = {*beside, *(c.effect for c in chosen)}
    lags = [candidate for _, candidate in others if candidate.law.family == LAGS]
    # Lags are each other's rivals: where one is fitted, none of them may be left out.
    if any(CATALOGUE[name].family == LAGS for name in fitted):
        return chosen + [c for c in lags if c.effect not in fitted]
    return chosen + _lags_beyond(misfit, base, [c for c in shapes if c.law.family == LAGS])


def _lags_beyond(misfit: Misfit, base: Fitted, starts: Sequence[Candidate]) -> list[Candidate]:
    """Lags from a start at which a few steps of one of them lead below the model without.

    A parameter that has made up for a lag keeps every short one from explaining more, and one step
    from a longer one does not undo it: the way down begins beyond that.
    """
    if not starts:
        return []
    first = starts[0].effect

    def lasting(candidate: Candidate) -> float:
        return next(iter(candidate.values.values()))

    def after_a_few_steps(candidate: Candidate) -> float:
        hypothesis = with_effect(base.hypothesis, candidate)
        found = fit(misfit, hypothesis, base.parameters, near=base, iterations=_A_FEW)
        return np.inf if found is None else found.chi2

    shortest = [c for c in starts if c.effect == first][:_SHORTEST]
    squares = misfit.simulations.map_outer(after_a_few_steps, shortest)
    best = int(np.argmin(squares))
    if squares[best] >= base.chi2 - _WORTH_OTHERS:
        return []
    nearest: dict[str, Candidate] = {}
    for candidate in sorted(starts, key=lambda c: abs(lasting(c) - lasting(shortest[best]))):
        nearest.setdefault(candidate.effect, candidate)
    return list(nearest.values())
