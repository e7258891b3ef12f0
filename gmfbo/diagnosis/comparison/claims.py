"""What may be said of a scored ledger: laws above their floors, alone or as sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.ledger import Scored
from gmfbo.diagnosis.comparison.numbers import NAMED
from gmfbo.diagnosis.comparison.posterior_mode import Fitted
from gmfbo.diagnosis.comparison.priors import bounds_of, values_at
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.physics import CATALOGUE

Array = NDArray[np.float64]

_DRAWS = 400


@dataclass(frozen=True)
class Claim:
    """One place that a law, or one of a set of laws, occupies.

    Attributes
    ----------
    members : tuple of str
        Effects, and freed parameters as `parameter:NAME`; the most believed first.
    beliefs : tuple of float
        Of each member.
    """

    members: tuple[str, ...]
    beliefs: tuple[float, ...]

    @property
    def probability(self) -> float:
        """That one of the members is there."""
        return float(sum(self.beliefs))


def posterior_draws(fitted: Fitted, whitening: Whitening, seed: int = 0) -> Array:
    """Values of the free quantities under the parabola about a fit, shape (draws, p).

    Draws beyond a bound are put onto it.

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    whitening : Whitening
        By noise.
    seed : int
        Of the draws.
    """
    a = np.diag(fitted.curvatures)
    for j in whitening(fitted.columns):
        flat = j.reshape(j.shape[0], -1)
        a = a + flat @ flat.T
    p = fitted.u.size
    spread = np.linalg.inv(a)[:p, :p]
    rng = np.random.default_rng(seed)
    z = rng.standard_normal((_DRAWS, p))
    u = fitted.u + z @ np.linalg.cholesky(spread).T if p else z
    ends = bounds_of(fitted.priors)
    u = np.clip(u, ends[:, 0], ends[:, 1])
    return np.array([values_at(fitted.priors, row) for row in u]).reshape(_DRAWS, p)


def shares_above_floor(fitted: Fitted, whitening: Whitening) -> dict[str, float]:
    """Probability that each element of a fit is above its floor; 1 for a freed parameter."""
    found = {f"parameter:{name}": 1.0 for name in fitted.freed}
    if not fitted.hypothesis.effects:
        return found
    excitation = fitted.hypothesis.setting.excitation
    draws = posterior_draws(fitted, whitening)
    above = dict.fromkeys((c.effect for c in fitted.hypothesis.effects), 0)
    for x in draws:
        for candidate in fitted.hypothesis.at(x).effects:
            law, values = candidate.law, {**candidate.more, **candidate.values}
            above[candidate.effect] += law.size(values, excitation) >= law.floor(excitation)
    return found | {name: count / _DRAWS for name, count in above.items()}


def claims_of(
    scored: Scored, best: frozenset[str], above: Mapping[frozenset[str], Mapping[str, float]]
) -> tuple[Claim, ...]:
    """For each place of the best row, the smallest set of elements that holds it.

    Parameters
    ----------
    scored : Scored
        Beliefs in rows.
    best : frozenset of str
        The best row.
    above : mapping of frozenset of str to mapping of str to float
        By row and element, the probability that its size is above its floor.
    """
    told = []
    for element in sorted(best):
        masses: dict[str, float] = {}
        for row, belief in zip(scored.elements, scored.beliefs, strict=True):
            holder = element if element in row else _instead(row - best, above[row])
            if holder is not None:
                share = above[row].get(holder, 1.0)
                masses[holder] = masses.get(holder, 0.0) + float(belief) * share
        told.append(_smallest(masses))
    return tuple(told)


def _instead(others: frozenset[str], above: Mapping[str, float]) -> str | None:
    """Element that a row holds in the place of one that it lacks."""
    return max(sorted(others), key=lambda name: above.get(name, 1.0), default=None)


def _smallest(masses: dict[str, float]) -> Claim:
    total, kept = sum(masses.values()), dict[str, float]()
    for name, mass in sorted(masses.items(), key=lambda item: -item[1]):
        if sum(kept.values()) >= NAMED * total:
            break
        kept[name] = mass
    for name in list(kept):
        within = [n for n in kept if n in CATALOGUE and name in CATALOGUE[n].contains]
        for larger in within:
            kept[name] += kept.pop(larger)
    order = sorted(kept, key=lambda name: -kept[name])
    return Claim(tuple(order), tuple(kept[name] for name in order))
