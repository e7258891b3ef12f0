"""By how much chi2 changes where nothing but the counts of the twin's own encoder do."""

from __future__ import annotations

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2

_DRAWS = 8
_DEVIATIONS = 2.0


def gain_by_chance(misfit: Misfit, fitted: Fitted, rng: np.random.Generator) -> float:
    """Gain that a fit may have by meeting the recorded counts by chance; zero in a smooth twin.

    The parameters are moved by steps that shuffle the counts, and what the sensitivities foresee
    is taken out again: what chi2 rises by on average the fit owes to its luck, and what it varies
    by another fit may.
    """
    hypothesis, x = fitted.hypothesis, fitted.x
    if not hypothesis.setting.is_rough:
        return 0.0
    sizes = DIFFERENCE_STEP * hypothesis.magnitudes(x)
    low, high = hypothesis.bounds
    moves = sizes * rng.uniform(-1.0, 1.0, (_DRAWS, x.size))
    moves = np.clip(x + moves, low, high) - x
    runs = misfit.run_moved(hypothesis, x, moves, parallel=True)
    squares = []
    for move, run in zip(moves, runs, strict=True):
        if all(one.finite for one in run):
            moved = zip(misfit.residual(run), fitted.sensitivity, strict=True)
            squares.append(chi2(tuple(left + move @ change for left, change in moved)))
    if not squares:
        return 0.0
    luck = max(float(np.mean(squares)) - fitted.chi2, 0.0)
    return luck + _DEVIATIONS * float(np.std(squares))
