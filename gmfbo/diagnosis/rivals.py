"""Effects that these recordings cannot tell from the one that fits best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.decision import Evidence
from gmfbo.physics.effect import Effect

AS_GOOD = 0.8
"""Of the gain, from which only the way that physics is stepped sets two ends of a loop apart."""

_QUANTILE = 1.645  # of a normal variable: 95 %


def rivals_of(winner: Evidence, others: Sequence[Evidence]) -> list[Evidence]:
    """Effects whose misfit is one that they would show if they were the truth.

    If rival r is true, chi2(r) - chi2(winner) is normal with mean -D and variance 4 D, where D is
    the squared distance of the two fitted models (Vuong 1989): the noise is the same in both.

    Parameters
    ----------
    winner : Evidence
        What fits best.
    others : sequence of Evidence
        What was fitted beside it, everything free.
    """
    rivals = []
    for other in others:
        if other.name == winner.name or _has_as_limit(other.effect.law, winner.name):
            continue
        if other.name in winner.effect.law.same_loop and other.gain > AS_GOOD * winner.gain:
            rivals.append(other)
            continue
        distance = sum(
            float(np.sum((a - b) ** 2))
            for a, b in zip(other.fitted.residual, winner.fitted.residual, strict=True)
        )
        bound = max(0.0, -distance + 2.0 * _QUANTILE * np.sqrt(distance))
        if other.chi2 - winner.chi2 <= bound:
            rivals.append(other)
    return rivals


def _has_as_limit(law: Effect, name: str) -> bool:
    """Whether a law explains as much as another one only by having it as its limit.

    Gravity is no constant torque however small it is: where it does as well, it may be at work.
    """
    return name in law.contains and name not in law.flattens_to
