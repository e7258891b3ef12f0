"""Decide which effects are missing: screened, fitted, and held to what the fit has not seen."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case, is_more_than_noise
from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.naming.conditions import needed_gain
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.naming.library_dispersion import narrow_budget
from gmfbo.diagnosis.naming.rivals import rivals_beside
from gmfbo.diagnosis.naming.selection_round import accept, fits_of_round, go_where_led
from gmfbo.diagnosis.naming.start_at_rest import screen_both_starts
from gmfbo.diagnosis.naming.swapped_first import exchange_first
from gmfbo.diagnosis.screening.limit_scan import SCANNED
from gmfbo.diagnosis.screening.probes import Probe, probes, screen

MOST_EFFECTS = 3
"""Effects that are named at most; recordings of a few seconds do not tell more apart."""

_NOTHING = "changes nothing in these recordings"
_LEAST_UNLIKE = 0.03  # of an effect's change that no parameter makes


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
        _look_beside(case, decision, library, look_again)
        fits = fits_of_round(case, decision, rng)
        if go_where_led(case, decision, fits):
            _look_beside(case, decision, library, look_again)
            fits = fits_of_round(case, decision, rng)
        if not accept(case, decision, fits, rng):
            return


def _look_beside(
    case: Case,
    decision: Decision,
    library: Sequence[Candidate],
    look_again: Callable[[Fitted], list[Candidate]],
) -> None:
    """What is tried beside named effects."""
    if not decision.rounds:
        return
    assert decision.model is not None
    more = look_again(decision.model)
    if not is_more_than_noise(case, decision.model):
        decision.tried = [*decision.tried, *probes(case.misfit, decision.model, more)]
        return
    # About a model that is far from the first one, effects look otherwise.
    testable = [c for c in library if c.effect not in decision.like_parameters]
    decision.tried = probes(case.misfit, decision.model, [*testable, *more])
    narrow_budget(case, decision)


def _apart_from_parameters(
    case: Case, tried: Sequence[Probe]
) -> tuple[list[Probe], dict[str, str]]:
    """Leave out effects that the refitted parameters can make by themselves.

    Limits stay where none of their grid is ever met: they are looked for at every size.
    """
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
    unmet = {name for name in SCANNED if alike.get(name) == _NOTHING}
    return [p for p in tried if p.candidate.effect not in alike.keys() - unmet], alike


def _nearest_parameter(case: Case, probe: Probe) -> str:
    """Why an effect is left out: the parameter whose sensitivity is most parallel to its change."""
    columns = stacked(case.misfit, probe.columns[:1])
    if not case.base.x.size or not any(np.any(change) for change in columns):
        return _NOTHING
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
