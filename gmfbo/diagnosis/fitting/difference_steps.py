"""Finite-difference steps that exceed the roughness of the twin's responses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Hypothesis
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2

_WIDER = (0.08, 0.32, 1.28)
_SMOOTH = 0.1  # roughness below which no other step is tried


def with_clear_steps(
    misfit: Misfit, hypothesis: Hypothesis, parameters: Mapping[str, float], *, parallel: bool
) -> Hypothesis:
    """Move each free parameter far enough to outweigh the roughness of its responses.

    An encoder's counts inside the twin's loop dither its command. Any small change shuffles them,
    so that each difference of two runs holds that noise. A Gauss-Newton step by such a Jacobian is
    too short (errors in regressors attenuate a slope; Fuller 1987, section 1.1), and a fit ends
    long before the minimum.

    Parameters
    ----------
    misfit : Misfit
        Recordings, simulators and a budget.
    hypothesis : Hypothesis
        Its free parameters; steps that its setting already has are kept.
    parameters : mapping of str to float
        Of the twin; parameters are moved about these values.
    parallel : bool
        Use all simulators.

    Returns
    -------
    Hypothesis
        The hypothesis with a step for each free parameter in its setting.
    """
    x, known = hypothesis.start(parameters), hypothesis.setting.difference_steps
    steps = {name: DIFFERENCE_STEP for name in hypothesis.names if name not in known}
    if not steps:
        return hypothesis
    least = _roughness(misfit, hypothesis, x, steps, parallel)
    rough = [name for name, seen in least.items() if seen > _SMOOTH]
    for step in _WIDER if rough else ():
        seen = _roughness(misfit, hypothesis, x, dict.fromkeys(rough, step), parallel)
        better = {name for name in seen if seen[name] < least[name]}
        steps |= dict.fromkeys(better, step)
        least |= {name: seen[name] for name in better}
    setting = replace(hypothesis.setting, difference_steps={**known, **steps})
    return replace(hypothesis, setting=setting)


def _roughness(
    misfit: Misfit,
    hypothesis: Hypothesis,
    x: NDArray[np.float64],
    steps: Mapping[str, float],
    parallel: bool,
) -> dict[str, float]:
    """Square of the second difference over that of the first, where the range holds both.

    The ratio is far below one for a smooth response and three for noise; for a bent response it
    grows with the square of the step.
    """
    names, moves = _moves_in_range(hypothesis, x, steps)
    base, *runs = misfit.run_moved(hypothesis, x, moves, parallel=parallel)
    found = {}
    for name, once, twice in zip(names, runs[::2], runs[1::2], strict=True):
        if not all(run.finite for run in (*once, *twice)):
            continue
        first, second = misfit.change(once, base), misfit.change(twice, once)
        bent = chi2(tuple(b - a for a, b in zip(first, second, strict=True)))
        found[name] = bent / max(chi2(first), 1e-300)
    return found


def _moves_in_range(
    hypothesis: Hypothesis, x: NDArray[np.float64], steps: Mapping[str, float]
) -> tuple[list[str], NDArray[np.float64]]:
    """Parameters whose range holds two steps, and moves of zero, one and two steps of each."""
    low, high = hypothesis.bounds
    magnitudes = dict(zip(hypothesis.names, hypothesis.magnitudes(x), strict=True))
    names, moves = [], [np.zeros(x.size)]
    for name, share in steps.items():
        move = np.zeros(x.size)
        i = hypothesis.names.index(name)
        move[i] = share * magnitudes[name]
        if x[i] + 2.0 * move[i] > high[i]:
            move = -move
        if low[i] <= x[i] + 2.0 * move[i] <= high[i]:
            names.append(name)
            moves += [move, 2.0 * move]
    return names, np.array(moves)
