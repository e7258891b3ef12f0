"""Effects that these recordings cannot tell from the one that fits best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted, fit
from gmfbo.diagnosis.naming.decision import Evidence
from gmfbo.physics.effect import Effect

AS_GOOD = 0.8
"""Of the gain, from which only the way that physics is stepped sets two ends of a loop apart."""

_QUANTILE = 1.645  # of a normal variable: 95 %


def rivals_of(winner: Evidence, others: Sequence[Evidence]) -> list[Evidence]:
    """Effects whose misfit is one that they would show if they were the truth.

    If rival r is true, chi2(r) - chi2(winner) is normal with mean -D and variance 4 D, where D is
    the squared distance of the two fitted models (Vuong 1989): the noise is the same in both.
    """
    rivals = []
    for other in others:
        if other.name == winner.name or _has_as_limit(other.effect.law, winner.name):
            continue
        if other.name in winner.effect.law.same_loop and other.gain > AS_GOOD * winner.gain:
            rivals.append(other)
            continue
        if _does_as_well(other.fitted, winner.fitted):
            rivals.append(other)
    return rivals


def rivals_beside(
    case: Case, model: Fitted, place: int, rivals: Sequence[Evidence]
) -> tuple[Evidence, ...]:
    """Those of an effect's rivals that still are, where they stand beside what was found later.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model : Fitted
        The twin with all named effects.
    place : int
        Which of them has the rivals.
    rivals : sequence of Evidence
        Each fitted without what was found later.
    """
    effects = model.hypothesis.effects
    winner, others = effects[place], effects[:place] + effects[place + 1 :]
    kept = []
    for rival in rivals:
        if rival.name in {c.effect for c in others}:
            continue
        if rival.name not in winner.law.same_loop:
            hypothesis = replace(model.hypothesis, effects=(*others, rival.effect))
            fitted = fit(case.misfit, hypothesis, rival.fitted.parameters, parallel=True)
            if fitted is None or not _does_as_well(fitted, model):
                continue
        kept.append(rival)
    return tuple(kept)


def _does_as_well(other: Fitted, winner: Fitted) -> bool:
    """Whether the other one would fit as much worse if it were the truth."""
    residuals = zip(other.residual, winner.residual, strict=True)
    distance = sum(float(np.sum((a - b) ** 2)) for a, b in residuals)
    return bool(other.chi2 - winner.chi2 <= chance_of_rival(distance))


def chance_of_rival(distance: float) -> float:
    """By how much a true rival may leave more chi2 than the best does, in 95 % of recordings.

    Parameters
    ----------
    distance : float
        Square of the distance of the two fitted models, in units of noise.
    """
    return max(0.0, -distance + 2.0 * _QUANTILE * float(np.sqrt(distance)))


def _has_as_limit(law: Effect, name: str) -> bool:
    """Whether a law explains as much as another one only by having it as its limit.

    Gravity is no constant torque however small it is: where it does as well, it may be at work.
    """
    return name in law.contains and name not in law.flattens_to
