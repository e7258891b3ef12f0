"""Other values of a hypothesis that recordings like as well: where its parabola does not hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import grams, log_evidences, weightings
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.numbers import FAR_BEHIND, MOST, SAME
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_TRIED, _SEARCHED = 16, 4  # points, and those of them that are searched from
_FACTOR = 3.0  # standard deviation of these points about a fit


def other_modes(problem: Problem, whitening: Whitening, row: Fitted) -> list[Fitted]:
    """Further fits of a hypothesis that begin far from one of it.

    A load that bounces, or friction that holds and lets go, makes the log density rough: a search
    ends in one of many hollows, whose own parabola is far too narrow. Points are drawn within about
    a factor of two of the values of laws. Where more than half of what the parabola foretells to be
    lost there is not lost, another search begins.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    whitening : Whitening
        Under which the hypothesis is fitted.
    row : Fitted
        A fit.
    """
    bends = _bends(row)
    if not bends.any():
        return []
    inner = grams(problem, row.beside_own_parts(whitening), row)
    curvature = inner.matrices.sum(0) + np.diag(row.curvatures)
    here = _begun(problem, whitening, row, row.x)
    if here is None:
        return []
    rng, begun = np.random.default_rng(0), []
    for _ in range(_TRIED):
        x = row.x * np.where(bends, _FACTOR ** rng.standard_normal(row.x.size), 1.0)
        there = _begun(problem, whitening, row, x)
        if there is None:
            continue
        step = np.zeros(len(curvature))
        step[: row.u.size] = there[1].u - here[1].u
        foretold, lost = 0.5 * step @ curvature @ step, there[2] - here[2]
        if foretold > FAR_BEHIND and lost < MOST * foretold:
            begun.append((lost, there[0], there[1]))
    begun.sort(key=lambda one: one[0])
    modes = [row]
    for _, search, at in begun[:_SEARCHED]:
        found = search.fitted_from(at, rival=here[2])
        if all(_apart(found, mode, whitening) for mode in modes):
            modes.append(found)
    return modes[1:]


def shares_of(problem: Problem, whitening: Whitening, modes: list[Fitted]) -> Array:
    """Belief in each of several fits of a hypothesis, shape (n_modes,).

    As that in hypotheses it is the mean over weightings of the stretches (Huggins and Miller 2023).

    Parameters
    ----------
    problem : Problem
        Stretches.
    whitening : Whitening
        Under which they are fitted.
    modes : list of Fitted
        Those fits.
    """
    inner = [grams(problem, mode.beside_own_parts(whitening), mode) for mode in modes]
    weights = weightings(len(inner[0].squares))
    logs = np.array([log_evidences(*one, weights) for one in zip(modes, inner, strict=True)])
    shares = np.exp(logs - logs.max(0))
    return np.asarray((shares / shares.sum(0)).mean(1), dtype=np.float64)


def _bends(row: Fitted) -> NDArray[np.bool_]:
    """Quantities of laws that are not linear; but for lines and instants, which a search found."""
    hypothesis = row.hypothesis
    searched = [c.law.is_searched for c in hypothesis.effects for _ in c.parameters]
    own = [False] * len(hypothesis.setting.uncertain)
    found = np.array([*own, *searched], dtype=bool)
    bends: NDArray[np.bool_] = np.array(hypothesis.bent, dtype=bool) & ~found
    return bends


def _begun(
    problem: Problem, whitening: Whitening, row: Fitted, x: Array
) -> tuple[ModeSearch, Fitted, float] | None:
    """A search from values near those of a fit, where it begins, and its cost [nats] there."""
    low, high = np.array([(p.low, p.high) for p in row.priors]).T
    hypothesis = row.hypothesis.at(np.clip(x, low, high))
    search = ModeSearch(problem, whitening, hypothesis, row.freed, row.heard)
    at = search.begun(row.parameters, row.nuisances, row)
    return None if at is None else (search, at, search.cost(at))


def _apart(one: Fitted, other: Fitted, whitening: Whitening) -> bool:
    change = [a - b for a, b in zip(one.residual, other.residual, strict=True)]
    return whitening.square(change) > SAME
