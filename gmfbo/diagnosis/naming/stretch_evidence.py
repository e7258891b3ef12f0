"""What each stretch of the recordings tells of a claim, and whether one alone tells it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted as Row
from gmfbo.diagnosis.comparison.numbers import FEW_STRETCHES, named_log_odds
from gmfbo.diagnosis.comparison.row_fits import lacking
from gmfbo.diagnosis.naming.decision import Compared
from gmfbo.plain_words import number

Array = NDArray[np.float64]


def gains_of(compared: Compared, row: Row, without: Row) -> list[Array]:
    """Fall of the whitened square in each stretch, by segment."""
    problem, whitening = compared.search.problem, compared.ledger.whitening
    before, after = (
        problem.by_stretch([z**2 for z in one.beside_own_parts(whitening)(one.residual)])
        for one in (without, row)
    )
    return [a - b for a, b in zip(before, after, strict=True)]


def per_recording(
    names: Sequence[str], compared: Compared, gains: Sequence[Array]
) -> dict[str, float]:
    """Fall of the whitened square in each recording, by its name."""
    total: dict[str, float] = {}
    for segment, own in zip(compared.search.problem.segments, gains, strict=True):
        name = names[segment.record]
        total[name] = total.get(name, 0.0) + float(own.sum())
    return total


def acting_of(compared: Compared, row: Row, name: str, gains: Sequence[Array]) -> Sequence[Array]:
    """Whitened square of what an effect changes in each stretch; gains where it is not known."""
    problem, whitening = compared.search.problem, compared.ledger.whitening.by_noise
    points = [
        problem.point(one.hypothesis, one.x, one.own_values) for one in (row, lacking(row, name))
    ]
    runs = problem.simulations.run(points)
    if not all(run.finite for one in runs for run in one):
        return gains
    change = [a - b for a, b in zip(*(problem.values(one) for one in runs), strict=True)]
    return problem.by_stretch([z**2 for z in whitening(change)])


def seen_once(
    names: Sequence[str], compared: Compared, gains: Sequence[Array], acting: Sequence[Array]
) -> str:
    """Stretch without which nothing would be said; empty where others tell it as well.

    An event may lie across two stretches, and a loop answers it in the next one: where there are
    enough, those beside it are no others. Nor does a stretch tell in which the effect does not act:
    what falls there is what parameters had taken over.

    Parameters
    ----------
    names : sequence of str
        Of the recordings.
    compared : Compared
        For the stretches.
    gains : sequence of ndarray
        Fall of the whitened square in each stretch, by segment.
    acting : sequence of ndarray
        Whitened square of what the effect changes there.
    """
    problem = compared.search.problem
    k = int(np.argmax([own.max() for own in gains]))
    most = int(np.argmax(gains[k]))
    beside = 1 if sum(own.size for own in gains) >= FEW_STRETCHES else 0
    event = slice(max(most - beside, 0), most + beside + 1)
    others = min(_sum_without(gains, k, event), _sum_without(acting, k, event))
    if 0.5 * others > named_log_odds():
        return ""
    segment, rows = problem.segments[k], problem.stretches()[k][most]
    first, last = (number(float(segment.time[rows][end])) for end in (0, -1))
    return f"{names[segment.record]} {first}-{last} s"


def _sum_without(values: Sequence[Array], segment: int, stretches: slice) -> float:
    return sum(float(own.sum()) for own in values) - float(values[segment][stretches].sum())
