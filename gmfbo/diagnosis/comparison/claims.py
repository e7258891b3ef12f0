"""What may be said of a scored ledger: laws above their floors, alone or as sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import (
    LEAST_STRETCHES,
    Grams,
    spread_moves,
    weightings,
)
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Scored
from gmfbo.diagnosis.comparison.numbers import FIXED_FLOOR, NAMED
from gmfbo.diagnosis.comparison.priors import bounds_of, values_at
from gmfbo.physics import CATALOGUE

Array = NDArray[np.float64]

_MOST_SETS = 10_000  # of one size that are looked at: a tenth of a second


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


def posterior_draws(fitted: Fitted, inner: Grams, seed: int = 0) -> Array:
    """Values of the free quantities by the bagged posterior about a fit, shape (draws, p).

    Each is drawn under the parabola of one weighting of the stretches (Huggins and Miller 2023), as
    the evidence is: where what is left is more than noise, stretches ask for different values.
    Draws beyond a bound are put onto it.

    Parameters
    ----------
    fitted : Fitted
        A hypothesis at its best values.
    inner : Grams
        Of its columns.
    seed : int
        Of the draws.
    """
    p = fitted.u.size
    weights = weightings(len(inner.squares))
    if len(inner.squares) < LEAST_STRETCHES:
        weights = np.ones_like(weights)
    tilted = np.tensordot(weights, inner.matrices, 1) + np.diag(fitted.curvatures)
    spread = np.linalg.cholesky(np.linalg.inv(tilted)[:, :p, :p])
    z = np.random.default_rng(seed).standard_normal((len(weights), p))
    moved = spread_moves(fitted, inner, weights)[:, :p] + np.einsum("dij,dj->di", spread, z)
    ends = bounds_of(fitted.priors)
    u = np.clip(fitted.u + moved, ends[:, 0], ends[:, 1])
    return np.array([values_at(fitted.priors, row) for row in u]).reshape(len(weights), p)


def shares_above_floor(fitted: Fitted, inner: Grams) -> dict[str, float]:
    """Probability that each element of a fit is above its floor; arguments as above."""
    setting = fitted.hypothesis.setting
    above = dict.fromkeys(fitted.elements, 0)
    if not above:
        return {}
    drawn = posterior_draws(fitted, inner)
    for x in drawn:
        at = fitted.hypothesis.at(x)
        for candidate in at.effects:
            law, values = candidate.law, {**candidate.more, **candidate.values}
            enough = law.size(values, setting.excitation) >= law.floor(setting.excitation)
            above[candidate.effect] += enough
        parameters = at.parameters(x)
        for known in setting.uncertain:
            if known.name in fitted.freed:
                changed = abs(parameters[known.name] / known.nominal - 1.0)
                above[f"parameter:{known.name}"] += changed >= FIXED_FLOOR
    return {name: count / len(drawn) for name, count in above.items()}


def claims_of(
    scored: Scored, above: Mapping[frozenset[str], Mapping[str, float]]
) -> tuple[Claim, ...]:
    """Sets of elements of which one is there, the surest first, until none is believed.

    Each is the smallest set that meets what is believed to be there; of each row it then takes one
    member away, and the next set is looked for among what is left.

    Parameters
    ----------
    scored : Scored
        Beliefs in rows.
    above : mapping of frozenset of str to mapping of str to float
        By row and element, the probability that its size is above its floor.
    """
    left = [(set(row), float(belief), above[row]) for row, belief in _rows(scored)]
    told: list[Claim] = []
    while any(names for names, _, _ in left):
        kept = _smallest(left)
        claim = _collapsed(kept)
        if told and claim.probability < NAMED:
            break
        told.append(claim)
        for names, _, _ in left:
            taken = next((name for name in kept if name in names), None)
            names.discard(str(taken))
    return tuple(told)


def _rows(scored: Scored) -> list[tuple[frozenset[str], float]]:
    return list(zip(scored.elements, scored.beliefs.tolist(), strict=True))


_Left = Sequence[tuple[set[str], float, Mapping[str, float]]]


def _smallest(left: _Left) -> dict[str, float]:
    """The fewest elements that meet what is believed, each with what it adds, the most first.

    Of sets as small the likeliest. One that takes the likeliest element first may be larger: two
    laws of which one is in every row may both be less likely than a third that is in most. Where
    nothing is believed enough to be told, or there are too many sets, that one is taken.
    """
    names = sorted({name for own, _, _ in left for name in own})
    masses = np.array(
        [
            [belief * shares.get(name, 1.0) if name in own else 0.0 for name in names]
            for own, belief, shares in left
        ]
    )
    there = float(masses.max(1).sum())
    found = _greedy(masses, NAMED * there)
    if there >= NAMED:
        likely = _not_less_everywhere(masses)
        for count in range(1, len(found) + 1):
            if comb(len(likely), count) > _MOST_SETS:
                break
            sets = [list(one) for one in combinations(likely, count)]
            met = [float(masses[:, one].max(1).sum()) for one in sets]
            if max(met, default=0.0) >= NAMED * there:
                best = sets[int(np.argmax(met))]
                adds = _greedy(masses[:, best], float(max(met)) * (1.0 - 1e-12))
                return {names[best[k]]: mass for k, mass in adds.items()}
    return {names[k]: mass for k, mass in found.items()}


def _not_less_everywhere(masses: Array) -> list[int]:
    """Columns but for those that another one equals or exceeds in each row."""
    kept: list[int] = []
    for k in sorted(range(masses.shape[1]), key=lambda k: -masses[:, k].sum()):
        if not any(np.all(masses[:, j] >= masses[:, k]) for j in kept):
            kept.append(k)
    return kept


def _greedy(masses: Array, enough: float) -> dict[int, float]:
    """Columns by what each adds to the largest of a row, until the sum is enough."""
    kept: dict[int, float] = {}
    met = np.zeros(len(masses))
    while float(met.sum()) < enough:
        added = np.maximum(masses - met[:, None], 0.0).sum(0)
        most = int(np.argmax(added))
        if added[most] <= 0.0:
            break
        kept[most] = float(added[most])
        met = np.maximum(met, masses[:, most])
    return kept


def _collapsed(kept: Mapping[str, float]) -> Claim:
    """A set in which a law stands for those that hold it as their limit, and are believed less."""
    own = dict(kept)
    for name in list(own):
        for larger in [n for n in own if n in CATALOGUE and name in CATALOGUE[n].contains]:
            if kept[larger] <= kept[name]:
                own[name] += own.pop(larger)
    order = sorted(own, key=lambda name: -own[name])
    return Claim(tuple(order), tuple(own[name] for name in order))
