"""Quantum of a recorded column: encoder counts, steps of a converter, or written digits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_FEWEST = 10  # steps of which a quantum is told
_WHOLE = 0.9  # share of the steps that are multiples of it
_EXACT = 0.02  # quanta by which a multiple may be off
_UNEVEN = 0.1  # the same of counts that were rounded once more as they were written
_MOST_QUANTA = 4.5  # of a step that is compared with multiples of its quantum
_WIDER = 3.0  # times as far as before: there, a quantum known so far is off by a small part of it

Array = NDArray[np.float64]


def resolution(values: Array) -> float:
    """Quantum of a signal: most steps are multiples of it; 0 where there is none.

    It is the least step from row to row or, where a signal passes many counts a row, the least
    difference of any two of its values. Counts that are written with few digits are multiples of
    nothing; all values lie near a grid of counts all the same.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As recorded.
    """
    steps = _beyond_rounding(np.abs(np.diff(values)), values)
    if steps.size < _FEWEST:
        return 0.0
    of_rows = _whole(steps, float(np.quantile(steps, 0.02)))
    gaps = _beyond_rounding(np.diff(np.unique(values)), values)
    found = of_rows or _whole(gaps, float(gaps.min()))
    return (_on_grid(values, found) or found) if found else _on_grid(values, _count(steps))


def _beyond_rounding(differences: Array, values: Array) -> Array:
    return differences[differences > 1e-12 * max(1.0, float(np.abs(values).max()))]


def _whole(differences: Array, quantum: float) -> float:
    """The quantum, if most differences are multiples of it; else 0."""
    return quantum if _are_multiples(differences / quantum, _EXACT) else 0.0


def _are_multiples(shares: Array, within: float) -> bool:
    return float(np.mean(np.abs(shares - np.round(shares)) < within)) > _WHOLE


def _count(steps: Array) -> float:
    """Count of which the short steps are multiples, but for a last digit; 0 where there is none."""
    quantum = float(np.mean(steps[steps < 1.5 * steps.min()]))
    shares = steps[steps < _MOST_QUANTA * quantum] / quantum
    # A steady speed is one long step, no quantum.
    has_several = np.mean(shares > 1.5) > 1.0 - _WHOLE
    is_count = shares.size >= _FEWEST and has_several and _are_multiples(shares, _UNEVEN)
    return quantum if is_count else 0.0


def _on_grid(values: Array, quantum: float) -> float:
    """The quantum, sharpened by values that lie farther and farther apart; 0 off its grid."""
    own = np.unique(values)
    apart = own - own[own.size // 2]
    far, reach = float(np.abs(apart).max()), _MOST_QUANTA * quantum
    while quantum:
        inside = apart[np.abs(apart) <= reach]
        counts = np.round(inside / quantum)
        if not _are_multiples(inside / quantum, _UNEVEN):
            return 0.0
        if counts.any():
            quantum = float(counts @ inside / (counts @ counts))
        if reach >= far:
            break
        reach *= _WIDER
    return quantum
