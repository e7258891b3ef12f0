"""Finite-difference steps that exceed the roughness of the twin's responses, not their bends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.hypothesis import DIFFERENCE_STEP, Hypothesis
from gmfbo.diagnosis.fitting.misfit import Misfit, chi2

Array = NDArray[np.float64]
Judge = Callable[[Array], Sequence[float | None]]
"""Roughness of responses to pairs of moves, as `with_judged_steps` asks for it."""

_WIDER = (0.08, 0.32, 1.28)
_MOST_SHOWN = 20.0  # standard deviations of noise, by which a step changes all signals together
MUCH_SHOWN = 60.0
"""[standard deviations of noise] Change of all signals by a step that may be too long."""

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
    x = hypothesis.start(parameters)

    def judged(moves: Array) -> list[float | None]:
        base, *runs = misfit.run_moved(hypothesis, x, moves, parallel=parallel)
        changes = [
            misfit.change(run, base) if all(one.finite for one in run) else None for run in runs
        ]
        nothing = [0.0 * own for own in next((c for c in changes if c is not None), ())]
        return bent_shares([nothing, *changes], lambda own: chi2(tuple(own)))

    return with_judged_steps(hypothesis, x, judged)


def with_judged_steps(hypothesis: Hypothesis, x: Array, judged: Judge) -> Hypothesis:
    """Choose the step of each free parameter that has none yet by how rough its response is.

    Parameters
    ----------
    hypothesis : Hypothesis
        Its free parameters.
    x : ndarray, shape (n,)
        [FMU's unit] Values about which they are moved.
    judged : callable (moves)
        Moves of shape (1 + 2 k, n): of nothing, and of one and two steps of each of k parameters.
        Of each of the k the square of the second difference of its responses over that of the
        first, None where it can't be told. It is far below one for a smooth response and three
        for noise; for a bent response it grows with the square of the step.
    """
    known = hypothesis.setting.difference_steps
    steps = {name: DIFFERENCE_STEP for name in hypothesis.names if name not in known}
    if not steps:
        return hypothesis
    least = _roughness(hypothesis, x, steps, judged)
    for step in _WIDER:
        rough = [name for name, seen in least.items() if seen > _SMOOTH]
        seen = _roughness(hypothesis, x, dict.fromkeys(rough, step), judged) if rough else {}
        better = {name for name in seen if seen[name] < least[name]}
        steps |= dict.fromkeys(better, step)
        least |= {name: seen[name] for name in better}
    return hypothesis.moved_by({**known, **steps})


def with_finer_steps(
    hypothesis: Hypothesis, x: Array, shown: Mapping[str, float], judged: Judge
) -> Hypothesis:
    """Shorten steps that change the signals by much more than noise, where a law bends within them.

    A limit that cuts a few rows is known to a ten-thousandth of itself, and is gone within a usual
    step. Friction, though, is rough: a short step shows at which rows it happens to hold. So a
    shorter step is taken only where the response to it is smooth.

    Parameters
    ----------
    hypothesis : Hypothesis
        Its free parameters; steps that its setting already has are kept.
    x : ndarray, shape (n,)
        [FMU's unit] Values about which they are moved.
    shown : mapping of str to float
        [standard deviations of noise] Change of the signals by the usual step, of those to judge.
    judged : callable (moves)
        As of `with_judged_steps`.

    Returns
    -------
    Hypothesis
        With a step for each that is shortened; the same object where there is none.
    """
    known = hypothesis.setting.difference_steps
    usual = {name: DIFFERENCE_STEP for name in shown if name not in known}
    bent = _roughness(hypothesis, x, usual, judged) if usual else {}
    finer = {
        name: DIFFERENCE_STEP * _MOST_SHOWN / shown[name]
        for name, seen in bent.items()
        if seen > _SMOOTH
    }
    seen = _roughness(hypothesis, x, finer, judged) if finer else {}
    steps = {name: finer[name] for name, share in seen.items() if share <= _SMOOTH}
    if not steps:
        return hypothesis
    return hypothesis.moved_by({**known, **steps})


def bent_shares(
    responses: Sequence[Sequence[Array] | None], square: Callable[[Sequence[Array]], float]
) -> list[float | None]:
    """Square of second differences over that of first ones, as `with_judged_steps` asks for it.

    Parameters
    ----------
    responses : sequence
        Of nothing, and of one and two steps of each parameter; None where they are not finite.
    square : callable (sequence of ndarray)
        Of a change of a response.
    """
    base, found = responses[0], list[float | None]()
    for once, twice in zip(responses[1::2], responses[2::2], strict=True):
        if base is None or once is None or twice is None:
            found.append(None)
            continue
        first = [a - b for a, b in zip(once, base, strict=True)]
        bent = [c - 2.0 * a + b for a, b, c in zip(once, base, twice, strict=True)]
        found.append(square(bent) / max(square(first), 1e-300))
    return found


def _roughness(
    hypothesis: Hypothesis, x: Array, steps: Mapping[str, float], judged: Judge
) -> dict[str, float]:
    names, moves = _moves_in_range(hypothesis, x, steps)
    ratios = zip(names, judged(moves), strict=True)
    return {name: ratio for name, ratio in ratios if ratio is not None}


def _moves_in_range(
    hypothesis: Hypothesis, x: Array, steps: Mapping[str, float]
) -> tuple[list[str], Array]:
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
