"""What may be said of a scored ledger: laws above their floors, alone or as sets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.evidence import (
    LEAST_STRETCHES,
    Grams,
    tilted_parabola,
    weightings,
)
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Scored
from gmfbo.diagnosis.comparison.numbers import FIXED_FLOOR, NAMED
from gmfbo.diagnosis.comparison.priors import bounds_of, values_at
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.physics import CATALOGUE, Effect, Excitation

Array = NDArray[np.float64]

_MOST_SETS = 10_000  # of one size that are looked at: all sizes take a second or two


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
    moved, curvature = tilted_parabola(fitted, inner, weights)
    spread = np.linalg.cholesky(np.linalg.inv(curvature)[:, :p, :p])
    z = np.random.default_rng(seed).standard_normal((len(weights), p))
    ends = bounds_of(fitted.priors)
    drawn = fitted.u + moved[:, :p] + np.einsum("dij,dj->di", spread, z)
    u = np.clip(drawn, ends[:, 0], ends[:, 1])
    return np.array([values_at(fitted.priors, row) for row in u]).reshape(len(weights), p)


@dataclass(frozen=True)
class Shares:
    """How likely the elements of a fit are there.

    Attributes
    ----------
    above : mapping of str to float
        By element, the probability that its size is above its floor.
    as_limit : mapping of str to mapping of str to float
        By law and simpler law: that it is below its floor, but is this one above that one's.
    """

    above: Mapping[str, float] = field(default_factory=dict)
    as_limit: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def shares_above_floor(fitted: Fitted, inner: Grams) -> Shares:
    """How likely the elements of a fit are there; arguments as of `posterior_draws`."""
    if not fitted.elements:
        return Shares()
    setting = fitted.hypothesis.setting
    above = Counter[str]()
    limits = {c.effect: Counter[str]() for c in fitted.hypothesis.effects}
    drawn = posterior_draws(fitted, inner)
    for x in drawn:
        at = fitted.hypothesis.at(x)
        for candidate in at.effects:
            values = {**candidate.more, **candidate.values}
            if _is_there(candidate.law, values, setting.excitation):
                above[candidate.effect] += 1
                continue
            limits[candidate.effect].update(_limits_there(candidate, setting.excitation))
        parameters = at.parameters(x)
        for known in setting.uncertain:
            if known.name in fitted.freed:
                changed = abs(parameters[known.name] / known.nominal - 1.0)
                above[f"parameter:{known.name}"] += changed >= FIXED_FLOOR
    return Shares(
        {name: above[name] / len(drawn) for name in fitted.elements},
        {
            law: {name: count / len(drawn) for name, count in own.items()}
            for law, own in limits.items()
            if own
        },
    )


def _is_there(law: Effect, values: Mapping[str, float], excitation: Excitation) -> bool:
    return law.size(values, excitation) >= law.floor(excitation)


def _limits_there(candidate: Candidate, excitation: Excitation) -> list[str]:
    """Simpler laws that a law is where its own size is next to nothing."""
    law = candidate.law
    values = {law.as_limit[p]: v for p, v in candidate.values.items() if p in law.as_limit}
    simpler = [CATALOGUE[name] for name in law.contains]
    return [
        one.name
        for one in simpler
        if {p.name for p in one.parameters} <= values.keys() and _is_there(one, values, excitation)
    ]


def claims_of(scored: Scored, shares: Mapping[frozenset[str], Shares]) -> tuple[Claim, ...]:
    """Sets of elements of which one is there, the surest first, until none is believed.

    Each is the smallest set that meets what is believed to be there; of each row it then takes one
    member away, and the next set is looked for among what is left.

    Parameters
    ----------
    scored : Scored
        Beliefs in rows.
    shares : mapping of frozenset of str to Shares
        By row, how likely its elements are there.
    """
    left = [one for row, belief in _rows(scored) for one in _read(row, belief, shares[row])]
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


def _read(
    row: frozenset[str], belief: float, shares: Shares
) -> list[tuple[set[str], float, Mapping[str, float]]]:
    """A row as it stands, and with a law below its floor as the simpler one that it then is."""
    above, kept = dict(shares.above), 1.0
    read: list[tuple[set[str], float, Mapping[str, float]]] = []
    for law, simpler in shares.as_limit.items():
        for name, share in simpler.items():
            names = (set(row) - {law}) | {name}
            read.append((names, belief * share, {**shares.above, name: 1.0}))
            kept -= share
            above[law] = above.get(law, 1.0) / (1.0 - share) if share < 1.0 else 0.0
    return [(set(row), belief * max(kept, 0.0), above), *read]


_Left = Sequence[tuple[set[str], float, Mapping[str, float]]]


def _smallest(left: _Left) -> dict[str, float]:
    """The fewest elements that meet what is believed, each with what it adds, the most first.

    Rows with two of them have 5 % of belief at most: else they would not stand for each other. Of
    sets as small the likeliest is taken. One that takes the likeliest element first may be larger:
    two laws of which one is in every row may both be less likely than a third that is in most.
    Where all sets have laws that go together, the smallest of them is taken; where nothing is
    believed enough to be told, or there are too many sets, the likeliest elements.
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
    best = _set_of(masses, there, len(found)) if there >= NAMED else None
    if best is not None:
        met = float(masses[:, best].max(1).sum())
        adds = _greedy(masses[:, best], met * (1.0 - 1e-12))
        found = {best[k]: mass for k, mass in adds.items()}
    return {names[k]: mass for k, mass in found.items()}


def _set_of(masses: Array, there: float, enough: int) -> list[int] | None:
    """Columns of the smallest set of which hardly any row has two, or else of the smallest."""
    likely, smallest, least = _not_less_everywhere(masses), None, NAMED * there
    for count in range(1, max(enough, len(likely)) + 1):
        among = list(range(masses.shape[1]))
        if comb(len(among), count) > _MOST_SETS:
            among = likely
        if comb(len(among), count) > _MOST_SETS:
            break
        sets = [list(one) for one in combinations(among, count)]
        met = np.array([masses[:, one].max(1).sum() for one in sets])
        twice = np.array([masses[:, one].sum() for one in sets]) - met
        if smallest is None and (met >= least).any():
            first = int(np.argmax(np.where(met >= least, met - twice, -np.inf)))
            smallest = sets[first]
            if met[first] >= NAMED:
                least = NAMED  # a set that may be told gives way to no other
        is_apart = (met >= least) & (twice <= (1.0 - NAMED) * there)
        if is_apart.any():
            return sets[int(np.argmax(np.where(is_apart, met - twice, -np.inf)))]
    return smallest


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
