"""Whether something is missing that the library does not hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.diagnosis.case.case import Case, chi2_per_dof, is_more_than_noise
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.naming.conditions import MECHANICS
from gmfbo.diagnosis.naming.decision import Decision
from gmfbo.diagnosis.outside.free_function import Unnamed, unnamed
from gmfbo.diagnosis.outside.moved_residual import chance_of_moving
from gmfbo.diagnosis.outside.same_in_all_stretches import inconstant
from gmfbo.diagnosis.outside.state_features import families_with_ways
from gmfbo.diagnosis.result.reference_test import ResidualTest
from gmfbo.diagnosis.screening.port_response import PortResponse, measure_port_response
from gmfbo.errors import SimulationError

_FOLLOWS = 1.2  # times what chance and tolerance allow
_MOSTLY = 0.5  # of the error, which has to follow
_BETTER = 0.7  # a name that explains less than this share of what a free function does is none
_THRESHOLDS = 3.0  # that a free function has to gain: it has a dozen values
_BESIDE_SHARE = 0.01  # of the names' gain, which a function beside them may gain: laws are inexact
_NOISE_SHARE = 0.05  # the same where names leave no more than noise
_EXCESS_SHARE = 0.3  # of the misfit beyond noise, which it has to take away
_REST_SHARE = 0.4  # of what names leave beyond noise, which a function beside them takes away
_BY_CHANCE = 0.003  # as noise that does not move with the axis
_UNNAMED_SHARE = 0.1  # of the misfit beyond noise, which names may leave: no law is exact
_INSTEAD = 0.5  # of what passes, which a function of a state explains: then it is no chance
_STICKS = 0.25  # of noise, which right names may leave of an axis that sticks or rattles
_CLEAR = 100.0  # times the noise: in so large a misfit whatever a law leaves shows
_INCONSTANT = 0.05  # of the names' gain, which is lost where each stretch is foretold by the others
_NO_LAW = 400.0  # times the noise, which no right name leaves (a real servo's friction leaves 190)

MISMATCH = 4.0
"""chi2 per degree of freedom from which a misfit that follows the reference is real, although
nothing explains it.

Nulls of the blind benchmark leave 0.4 to 1.3; a drive's lag that is 30 % off with a clock that is
too leaves up to 2.6. Coloured noise leaves up to 23, but hardly follows the reference.
"""

FAR = 100.0
"""chi2 per degree of freedom from which a misfit is real whether it follows the reference or not:
ten times the noise. Short recordings cannot show that they follow it."""


@dataclass(frozen=True, eq=False)
class Outside:
    """A free function of one state against the names.

    Attributes
    ----------
    model : Unnamed
        Fitted about the twin with its parameters refitted, at the port where it explains more.
    gain : float
        Fall of chi2 on what was left out, by the best function of a state.
    named : float
        The same by all named effects together, or by the one that is too small to be named.
    is_better : bool
        The function explains what no name does.
    """

    model: Unnamed
    gain: float
    named: float
    is_better: bool


def look_outside(
    case: Case, decision: Decision, response: PortResponse, rng: np.random.Generator
) -> Outside:
    """Compare the named effects with a free function of velocity or position, and with noise.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        What was named.
    response : PortResponse
        From the torque port to the signals.
    rng : numpy Generator
        See `chance_of_moving`.
    """
    assert decision.model is not None
    # By the budget alone: what the best name leaves must not count as noise here.
    plain = case.plain
    base, with_names = case.base.measured_by(plain), decision.model.measured_by(plain)
    alone = replace(case, misfit=plain, base=base)
    model = unnamed(alone, base, response)
    named = base.chi2 - with_names.chi2
    if decision.too_small is not None:
        named = max(named, decision.too_small.gain)
    if not decision.rounds:
        others = [unnamed(alone, base, there) for there in _elsewhere(case, rng)]
        model = max([model, *others], key=_best)
    is_better = _explains_instead(alone, decision, model, named)
    if decision.rounds and not is_better:
        judged = replace(case, misfit=plain, base=with_names)
        is_better = any(
            (
                _explains_more_beside(judged, decision, named, response, rng),
                _passes_by(decision) and _most_fall(model) > _INSTEAD * named,
                _leaves_too_much(judged, decision, base.chi2, rng),
            )
        )
        # Last, as it may simulate each stretch: only where nothing else has spoken.
        is_clear = base.chi2 >= _CLEAR * case.budget.noise
        is_better = is_better or (not is_clear and _differs_between_stretches(case, decision))
    return Outside(model, _best(model), named, is_better)


def _explains_instead(alone: Case, decision: Decision, model: Unnamed, named: float) -> bool:
    """Whether a free function explains most of what is beyond noise, and more than names."""
    gain, square = _best(model), alone.base.chi2
    dof = sum(w.n_residuals for w in alone.misfit.whiteners)
    left = max(1.0, (square - gain) / dof)
    is_large = gain / left > _THRESHOLDS * decision.threshold
    is_most = gain > _EXCESS_SHARE * (square - dof)
    return is_large and is_most and named < _BETTER * gain


def _elsewhere(case: Case, rng: np.random.Generator) -> list[PortResponse]:
    """Responses of the other ports, where no loop holds the twin on its recordings."""
    if case.simulations.tracking is not None:
        return []
    found = []
    for port in ("sensor", "command"):
        try:
            response = measure_port_response(case, port, rng)
        except SimulationError:
            continue  # what a port cannot bear says nothing
        if response is not None:
            found.append(response)
    return found


def _explains_more_beside(
    judged: Case,
    decision: Decision,
    named: float,
    response: PortResponse,
    rng: np.random.Generator,
) -> bool:
    """Whether a free function beside the names takes much of what they leave."""
    beside = max(
        _best(unnamed(judged, judged.base, there, families_with_ways))
        for there in (response, *_at_sensor(judged, decision, rng))
    )
    left_over = judged.base.chi2 - judged.budget.noise
    # When an axis sticks is chance: what friction leaves by it, a function of a state takes, too.
    is_beyond = left_over > _chance(decision) * judged.budget.noise
    share = _BESIDE_SHARE if is_beyond else _NOISE_SHARE
    least = max(_THRESHOLDS * decision.threshold, share * named)
    return beside > max(least, _REST_SHARE * left_over)


def _differs_between_stretches(case: Case, decision: Decision) -> bool:
    """Whether much of what names explain is lost where each stretch is foretold by the others.

    By the budget that decided on them: an inexact law is hardly the same everywhere.
    """
    assert decision.model is not None
    base, model = (f.measured_by(case.misfit) for f in (case.base, decision.model))
    lost = inconstant(case.misfit, model, decision.groups)
    return lost > _INCONSTANT * (base.chi2 - model.chi2)


def _leaves_too_much(
    judged: Case, decision: Decision, before: float, rng: np.random.Generator
) -> bool:
    """Whether names leave what no right ones do, or more of it in one motion than in another."""
    assert decision.model is not None
    noise, left = judged.budget.noise, judged.base.chi2
    if left - noise <= max(_UNNAMED_SHARE * (before - noise), _chance(decision) * noise):
        return False
    if left > _NO_LAW * noise:
        return True
    return before < _CLEAR * noise and is_uneven(judged, decision.model, rng)


def _chance(decision: Decision) -> float:
    """Share of noise that a right name may leave beyond it: when an axis sticks is chance."""
    families = {entry.winner.effect.law.family for entry in decision.rounds}
    return _STICKS if families & MECHANICS else 0.0


def _at_sensor(
    case: Case, decision: Decision, rng: np.random.Generator
) -> tuple[PortResponse, ...]:
    """Response of the sensor's port, where an error of the sensor is named: it may be another."""
    if all(entry.winner.effect.law.port != "sensor" for entry in decision.rounds):
        return ()
    found = measure_port_response(case, "sensor", rng)
    return () if found is None else (found,)


def _passes_by(decision: Decision) -> bool:
    """Whether all that is named passed once, in recordings that nothing else explains."""
    return all(entry.winner.effect.law.is_passing for entry in decision.rounds)


def _most_fall(model: Unnamed) -> float:
    """What the best function of a state explains by a fit to all.

    Where one recording alone goes far enough, no other can foretell what acts there.
    """
    return max((f.fall for f in model.families if f.family.shared), default=0.0)


def _best(model: Unnamed) -> float:
    return max((min(f.gain, f.fall) for f in model.families if f.family.shared), default=0.0)


def unexplained(case: Case, model: Fitted) -> float:
    """chi2 per degree of freedom that a model leaves by the budget alone.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted
        The twin refitted, with or without named effects.
    """
    return chi2_per_dof(model.measured_by(case.plain), case.plain)


def is_uneven(case: Case, model: Fitted, rng: np.random.Generator) -> bool:
    """Whether a model leaves more than noise does, and more of it in one motion than in another.

    Parameters
    ----------
    case : Case
        Twin, recordings and budget.
    model : Fitted
        The twin refitted, with or without named effects.
    rng : numpy Generator
        See `chance_of_moving`.
    """
    if case.simulations.tracking is not None:
        return False  # the loop that holds the twin makes noise follow the motion
    if not is_more_than_noise(case, model):
        return False
    return chance_of_moving(case, model, rng) < _BY_CHANCE


def is_mismatch(left: float, tests: Sequence[ResidualTest], errors: Mapping[str, float]) -> bool:
    """Whether what is left is no noise: noise of no colour follows the reference, or is as large.

    Parameters
    ----------
    left : float
        See `unexplained`.
    tests : sequence of ResidualTest
        Of held-out recordings.
    errors : mapping of str to float
        NRMSE of the refitted twin on them, for each signal.
    """
    follows = any(
        t.follows > max(_FOLLOWS * max(t.bound, t.tolerance), _MOSTLY * errors[t.signal])
        for t in tests
    )
    return left > FAR or (left > MISMATCH and follows)
