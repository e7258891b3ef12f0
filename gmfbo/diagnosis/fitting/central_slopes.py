"""Sensitivities by central differences, by which hidden directions are told from seen ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.misfit import Misfit


def with_central_slopes(misfit: Misfit, fitted: Fitted) -> Fitted:
    """Measure the sensitivities to the twin's own parameters on both sides of a fit.

    A one-sided difference is off by half a step of curvature. Where parameters can be scaled
    together without any change, as mass, stiffness and damping where no force acts, that error
    alone would make their common factor look known. A central difference is off by the square.

    Parameters
    ----------
    misfit : Misfit
        By which the model was fitted.
    fitted : Fitted
        A model at its best values.

    Returns
    -------
    Fitted
        The same values; a parameter whose range holds one side only keeps its sensitivity.
    """
    hypothesis, x = fitted.hypothesis, fitted.x
    steps = hypothesis.difference_sizes(x)
    low, high = hypothesis.bounds
    own = range(len(hypothesis.setting.uncertain))
    both = [i for i in own if low[i] <= x[i] - steps[i] <= high[i]]
    moves = np.zeros((len(both), x.size))
    moves[range(len(both)), both] = -steps[both]
    columns = list(fitted.columns)
    if not both:
        return fitted
    here, *moved = misfit.run_moved(
        hypothesis, x, np.concatenate([np.zeros((1, x.size)), moves]), parallel=True
    )
    for i, runs in zip(both, moved, strict=True):
        if not all(run.finite for run in runs):
            continue
        columns[i] = [
            tuple(
                0.5 * (ahead + (at - back) / steps[i])
                for ahead, at, back in zip(one_sided, base.signals, run.signals, strict=True)
            )
            for one_sided, base, run in zip(columns[i], here, runs, strict=True)
        ]
    return replace(fitted, columns=columns, sensitivity=stacked(misfit, columns))
