"""What a fitted effect gains on stretches that its fit has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.case import Case
from gmfbo.diagnosis.decision import Evidence
from gmfbo.diagnosis.fitting import Fitted
from gmfbo.diagnosis.left_out_runs import simulated_left_out, squares
from gmfbo.diagnosis.threshold import left_out_square

_PLAIN = 100.0  # gain on all, from which a limit is there, and the others only tell its size
_COMMENSURATE = 1.25  # times the square of its change, which an effect may gain
_DOUBTFUL = 0.7  # of the gain on all; less on what was left out is checked by simulation


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
        without = simulated_left_out(case.misfit, model, groups)
        told = [without - simulated_left_out(case.misfit, fitted, groups)]
        effect = fitted.hypothesis.effects[-1]
        if effect.law.family == "limit":
            # A limit that one stretch alone shows is unbound by the others: the best tells.
            told.append(outside)
            if inside.sum() > _PLAIN:
                held = len(effect.parameters)
                told.append(without - simulated_left_out(case.misfit, fitted, groups, held))
        outside = max(told, key=np.sum)
    gains = outside if outside.sum() < inside.sum() else inside
    signature = squares(
        tuple(a - b for a, b in zip(model.residual, fitted.residual, strict=True)), groups
    )
    # What takes r to r - d at its best takes |d|^2 away: more is what the model without it missed.
    most = _COMMENSURATE * signature.sum()
    if inside.sum() > most:
        gains = gains * most / inside.sum()
    return Evidence(fitted, gains, signature, fitted.chi2)
