"""What a fitted effect gains on stretches that its fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.simulated_left_out import simulated_left_out, squares
from gmfbo.diagnosis.naming.candidate_fits import LIMIT
from gmfbo.diagnosis.naming.decision import Evidence
from gmfbo.diagnosis.naming.threshold import left_out_square

Array = NDArray[np.float64]

_PLAIN = 100.0  # gain on all, from which a limit is there, and the others only tell its size
_COMMENSURATE = 1.25  # times the square of its change, which an effect may gain
_DOUBTFUL = 0.7  # of the gain on all; less on what was left out is checked by simulation
_ALL_THAT_WAS = 1.25  # times what other stretches leave, which one may that a limit has explained


def evidence_of(case: Case, model: Fitted, fitted: Fitted, groups: Sequence[int]) -> Evidence:
    """What a fitted effect gains over the model without it.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    model, fitted : Fitted
        Without the effect, and with it.
    groups : sequence of int
        Group of each window; whole groups are left out together.
    """
    before, after = squares(model.residual, groups), squares(fitted.residual, groups)
    inside = before - after
    outside = left_out_square(model, groups) - left_out_square(fitted, groups)
    if outside.sum() < _DOUBTFUL * inside.sum():
        # Sensitivities of a gap or a limit may be rough: let the FMU tell.
        is_whole = _is_plain_limit(fitted, inside) and _is_all_explained(
            inside, after, fitted, groups
        )
        outside = inside if is_whole else _simulated(case, model, fitted, groups, inside, outside)
    gains = outside if outside.sum() < inside.sum() else inside
    signature = squares(
        tuple(a - b for a, b in zip(model.residual, fitted.residual, strict=True)), groups
    )
    # What takes r to r - d at its best takes |d|^2 away: more is what the model without it missed.
    most = _COMMENSURATE * signature.sum()
    if inside.sum() > most:
        gains = gains * most / inside.sum()
    return Evidence(fitted, gains, signature, fitted.chi2)


def _simulated(
    case: Case,
    model: Fitted,
    fitted: Fitted,
    groups: Sequence[int],
    inside: Array,
    outside: Array,
) -> Array:
    """The gain on what was left out, each fit simulated; of a limit, the best of what tells it."""
    without = simulated_left_out(case.misfit, model, groups)
    told = [without - simulated_left_out(case.misfit, fitted, groups)]
    effect = fitted.hypothesis.effects[-1]
    if effect.law.family == LIMIT:
        # A limit that one stretch alone shows is unbound by the others: the best tells.
        told.append(outside)
    if _is_plain_limit(fitted, inside):
        held = len(effect.parameters)
        told.append(without - simulated_left_out(case.misfit, fitted, groups, held))
    return max(told, key=np.sum)


def _is_plain_limit(fitted: Fitted, inside: Array) -> bool:
    is_limit = fitted.hypothesis.effects[-1].law.family == LIMIT
    return is_limit and bool(inside.sum() > _PLAIN)


def _is_all_explained(inside: Array, after: Array, fitted: Fitted, groups: Sequence[int]) -> bool:
    """Whether an effect leaves no more of the stretch that it was seen in than of all others.

    A limit that is met for a few milliseconds is met by nothing but the twin that was fitted there:
    no other stretch can foretell it. What happens to be there besides would leave most of itself.
    """
    sizes = np.bincount(groups, [block.size for block in fitted.residual])
    left = after / sizes
    seen = int(np.argmax(inside))
    others = np.delete(left, seen)
    return bool(others.size) and bool(left[seen] <= _ALL_THAT_WAS * np.median(others))
