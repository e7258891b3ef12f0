"""Moves of the search: one element more, ranked by what a linear refit would gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.hypothesis import Candidate, Hypothesis
from gmfbo.sources.twin.uncertain import Uncertain

Array = NDArray[np.float64]

_FREED_STEP = 0.15  # of the value of a freed parameter
_OTHERS = 3  # further starts of a limit that are fitted
_SHOWN = 1.0  # whitened square of a start that these recordings do not show
_MOST = 1.6  # times the start: beyond it a straight line says little


@dataclass(frozen=True, eq=False)
class Element:
    """What a move adds: an effect at a start, or a freed parameter.

    Attributes
    ----------
    candidate : Candidate or None
        An effect.
    freed : Uncertain or None
        A parameter that the twin file holds fixed.
    share : float
        Of the usual step of a freed parameter, at which it starts.
    """

    candidate: Candidate | None = None
    freed: Uncertain | None = None
    share: float = 1.0

    @property
    def name(self) -> str:
        """As in a set: an effect, or `parameter:NAME`."""
        if self.candidate is not None:
            return self.candidate.effect
        assert self.freed is not None
        return f"parameter:{self.freed.name}"

    def added_to(self, hypothesis: Hypothesis) -> Hypothesis:
        """The hypothesis with it."""
        if self.candidate is not None:
            return replace(hypothesis, effects=(*hypothesis.effects, self.candidate))
        assert self.freed is not None
        setting = hypothesis.setting
        return replace(
            hypothesis, setting=replace(setting, uncertain=(*setting.uncertain, self.freed))
        )

    def start(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Values of the twin's parameters at its start."""
        if self.freed is None:
            return dict(parameters)
        moved = self.freed.nominal * (1.0 + self.share * _FREED_STEP)
        return {**parameters, self.freed.name: min(max(moved, self.freed.low), self.freed.high)}

    def sizes(self, hypothesis: Hypothesis) -> list[str]:
        """Parameters of an effect that are sizes, at whose zero it is gone."""
        if self.candidate is None:
            return []
        limits = self.candidate.law.bounds(hypothesis.setting.excitation)
        return [
            p.name for p in self.candidate.parameters if not p.hidden and limits[p.name][0] <= 0.0
        ]

    def can_shrink(self, hypothesis: Hypothesis) -> bool:
        """Whether an effect may begin with less of it: it has a size, or knows where it is gone."""
        if self.candidate is None or self.candidate.law.begins_whole:
            return False
        excitation = hypothesis.setting.excitation
        return bool(self.sizes(hypothesis) or self.candidate.law.gone(self._values, excitation))

    @property
    def _values(self) -> Mapping[str, float]:
        assert self.candidate is not None
        return self.candidate.values

    def moved(self, share: float, more: Mapping[str, float], hypothesis: Hypothesis) -> Element:
        """The same with its sizes or its step multiplied, and something added to some sizes."""
        if self.candidate is None:
            return replace(self, share=self.share * share)
        law, excitation = self.candidate.law, hypothesis.setting.excitation
        gone = {**dict.fromkeys(more, 0.0), **law.gone(self._values, excitation)}
        values = {
            name: gone[name] + share * (value - gone[name]) + more.get(name, 0.0)
            if name in gone
            else value
            for name, value in self._values.items()
        }
        return replace(self, candidate=self.candidate.with_values(values))

    def beginning_as(
        self, fitted: Sequence[Candidate], hypothesis: Hypothesis, share: float
    ) -> Element:
        """The same as a fitted limit of its law, with a share of the sizes that it has beside it.

        Parameters
        ----------
        fitted : sequence of Candidate
            Effects, one of which is a limit of this one.
        hypothesis : Hypothesis
            That it is added to.
        share : float
            Of its own sizes.
        """
        assert self.candidate is not None
        law = self.candidate.law
        limit = next(c for c in fitted if c.effect in law.contains)
        same = {p.name: p.name for p in law.own_nuisances} | dict(law.as_limit)
        sizes = self.sizes(hypothesis)
        values = {
            name: limit.values.get(same[name], value)
            if name in same
            else value * (share if name in sizes else 1.0)
            for name, value in self.candidate.values.items()
        }
        return replace(self, candidate=self.candidate.with_values(values))


@dataclass(frozen=True, eq=False)
class Move:
    """An element, what it would gain, and its start there.

    Attributes
    ----------
    element : Element
        At its scaled start.
    gain : float
        [nats] Of the linear refit.
    others : tuple of Element
        Next best starts of a limit: each cuts at another instant, and no fit leads from one to
        another.
    """

    element: Element
    gain: float
    others: tuple[Element, ...] = ()


@dataclass(frozen=True, eq=False)
class Response:
    """Change of the signals by an element at its start.

    Attributes
    ----------
    element : Element
        At its start.
    sizes : tuple of str
        Those of its sizes that are moved by themselves, after the start.
    steps : tuple of float
        By which they are moved.
    columns : list of ndarray, shape (1 + len(sizes), m, n)
        By segment: of the start, and of each size beyond it.
    is_signed : bool
        Whether the start may be reversed.
    """

    element: Element
    sizes: tuple[str, ...]
    steps: tuple[float, ...]
    columns: list[Array]
    is_signed: bool
    _white: list[tuple[Whitening, list[Array]]] = field(default_factory=list, repr=False)

    def whitened(self, whitening: Whitening) -> list[Array]:
        """Columns under a whitening without own parts, kept until another is asked for."""
        if not self._white or self._white[0][0] is not whitening:
            self._white[:] = [(whitening, whitening(self.columns))]
        return self._white[0][1]


def responses(problem: Problem, base: Fitted, elements: Sequence[Element]) -> list[Response]:
    """Change of the signals by each element; those that cannot be simulated are left out.

    Where an encoder's counts in the twin fall otherwise after any small change, the changes are
    measured a little beside the fit: what they owe to its counts would explain its residual.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    base : Fitted
        About which they are measured.
    elements : sequence of Element
        At their starts.
    """
    plans, points = [], []
    about, before = base, base.values
    if problem.is_counted or base.hypothesis.setting.is_rough:
        aside = base.aside()
        point = problem.point(aside.hypothesis, aside.x, aside.own_values)
        if (seen_aside := problem.simulated(point)) is not None:
            about, before = aside, seen_aside
    for element in elements:
        sizes = element.sizes(base.hypothesis)
        more = sizes if len(sizes) > 1 else []
        steps = [_step(element, base.hypothesis, name) for name in more]
        tried = [element]
        for name, step in zip(more, steps, strict=True):
            assert element.candidate is not None
            values = {**element.candidate.values, name: element.candidate.values[name] + step}
            tried.append(replace(element, candidate=element.candidate.with_values(values)))
        plans.append((element, sizes, more, steps, len(tried)))
        for one in tried:
            hypothesis = one.added_to(about.hypothesis)
            x = hypothesis.start(one.start(about.parameters))
            points.append(problem.point(hypothesis, x, about.own_values))
    runs = iter(problem.simulations.run(points))
    before, found = problem.as_stored(before, base.nuisances), []
    for element, sizes, more, steps, count in plans:
        own = [next(runs) for _ in range(count)]
        if not all(run.finite for one in own for run in one):
            continue
        seen = [problem.as_stored(problem.values(one), base.nuisances) for one in own]
        columns = [
            np.stack([v[0] - b, *(w - v[0] for w in v[1:])])
            for *v, b in zip(*seen, before, strict=True)
        ]
        found.append(
            Response(element, tuple(more), tuple(steps), columns, _is_signed(element, base, sizes))
        )
    return found


def _step(element: Element, hypothesis: Hypothesis, name: str) -> float:
    assert element.candidate is not None
    return float(0.5 * element.candidate.law.scales(hypothesis.setting.excitation)[name])


def _is_signed(element: Element, base: Fitted, sizes: Sequence[str]) -> bool:
    if element.candidate is None:
        return True
    limits = element.candidate.law.bounds(base.hypothesis.setting.excitation)
    return bool(sizes) and all(limits[name][0] < 0.0 for name in sizes)


def ranked(whitening: Whitening, about: Fitted, found: Sequence[Response]) -> list[Move]:
    """Best start of each element, those that gain most first.

    Parameters
    ----------
    whitening : Whitening
        By noise and the shared inadequacy.
    about : Fitted
        Hypothesis that the moves start from.
    found : sequence of Response
        Of the elements.
    """
    own_parts = about.beside_own_parts(whitening)
    j, inverse, left = _refitted(own_parts, about)
    moves: dict[str, list[Move]] = {}
    for response in found:
        name = response.element.name
        if name in about.elements:
            continue
        d = _flat(own_parts.of_own(response.whitened(whitening)))
        own = j @ d.T
        square = d @ d.T - own.T @ inverse @ own
        if np.diag(square).max() < _SHOWN:
            continue
        slope = d @ left
        shares, gain = _within(square, slope, response.is_signed)
        element = response.element
        sizes = dict.fromkeys(element.sizes(about.hypothesis), 0.0)
        sizes |= {
            n: float(c) * step
            for n, c, step in zip(response.sizes, shares[1:], response.steps, strict=True)
        }
        is_free = response.is_signed or element.can_shrink(about.hypothesis)
        kept = float(shares[0]) if is_free else 1.0
        moved = element.moved(kept or 0.2, sizes, about.hypothesis)
        moves.setdefault(name, []).append(Move(moved, gain))
    best = [_first_of(own, about.hypothesis) for own in moves.values()]
    return sorted(best, key=lambda move: -move.gain)


def _first_of(moves: Sequence[Move], hypothesis: Hypothesis) -> Move:
    """Best move of an element, with the next ones where it is a limit."""
    first, *others = sorted(moves, key=lambda move: -move.gain)
    if first.element.sizes(hypothesis) or not first.element.can_shrink(hypothesis):
        return first
    return replace(first, others=tuple(move.element for move in others[:_OTHERS]))


def start_gains(whitening: Whitening, about: Fitted, columns: Sequence[Array]) -> Array:
    """[nats] What the best multiples of changes of the signals gain beside a linear refit.

    Parameters
    ----------
    whitening : Whitening
        By noise and the shared inadequacy.
    about : Fitted
        Hypothesis whose free quantities are refitted.
    columns : sequence of ndarray, shape (k, m, n)
        [SI] By segment.

    Returns
    -------
    ndarray, shape (k,)
        Zero where the recordings do not show a change.
    """
    own_parts = about.beside_own_parts(whitening)
    j, inverse, left = _refitted(own_parts, about)
    d = _flat(own_parts(columns))
    own = j @ d.T
    squares, slopes = np.sum(d**2, axis=1) - np.sum(own * (inverse @ own), axis=0), d @ left
    shares = np.clip(slopes / np.maximum(squares, _SHOWN), 0.0, _MOST)
    return np.where(squares < _SHOWN, 0.0, shares * slopes - 0.5 * shares**2 * squares)


def _refitted(own_parts: Whitening, about: Fitted) -> tuple[Array, Array, Array]:
    """Whitened columns of a fit, their inverse products, and what a linear refit leaves."""
    z = _flat([r[None] for r in own_parts(about.residual)])[0]
    j = _flat(own_parts(about.columns))
    inverse = np.asarray(np.linalg.inv(j @ j.T + np.diag(about.curvatures)), dtype=np.float64)
    return j, inverse, z - j.T @ (inverse @ (j @ z))


def _within(square: Array, slope: Array, is_signed: bool) -> tuple[Array, float]:
    """Best multiples of the columns, that of the start within what a straight line can tell."""
    ridge = 1e-9 * np.diag(square) + 1e-12
    shares: Array = np.linalg.solve(square + np.diag(ridge), slope).astype(np.float64)
    first = float(np.clip(shares[0], -_MOST if is_signed else 0.0, _MOST))
    if first != shares[0]:
        rest = slope[1:] - first * square[1:, 0]
        inner = square[1:, 1:] + np.diag(ridge[1:])
        shares = np.concatenate([[first], np.linalg.solve(inner, rest)])
    return shares, float(shares @ slope - 0.5 * shares @ square @ shares)


def _flat(parts: Sequence[Array]) -> Array:
    return np.concatenate([v.reshape(v.shape[0], -1) for v in parts], axis=1)


@dataclass(frozen=True)
class Shown:
    """How well recordings show an element at its start.

    Attributes
    ----------
    element : Element
        At its start.
    information : float
        Whitened square of what it changes and no free quantity of a fit makes.
    unlike : float
        Share of the square of all it changes that no parameter makes; 0 where it changes nothing.
    nearest : str
        Free quantity whose change is most parallel to it.
    """

    element: Element
    information: float
    unlike: float
    nearest: str


def shown(whitening: Whitening, about: Fitted, found: Sequence[Response]) -> list[Shown]:
    """Tell how well recordings show each element, beside the free quantities of a fit.

    Parameters
    ----------
    whitening : Whitening
        By noise.
    about : Fitted
        The fit about which the responses were measured.
    found : sequence of Response
        Of the elements.
    """
    whitening = about.beside_own_parts(whitening)
    j = _flat(whitening(about.columns))
    own = j[: about.u.size]
    inverse = np.linalg.inv(j @ j.T + np.diag(about.curvatures))
    among = np.linalg.pinv(own @ own.T, hermitian=True)
    sizes = np.sqrt(np.maximum(np.sum(own**2, axis=1), 1e-300))
    names = about.hypothesis.names
    told = []
    for response in found:
        d = _flat(whitening([c[:1] for c in response.columns]))[0]
        whole, cross = float(d @ d), j @ d
        left = max(whole - float(cross @ inverse @ cross), 0.0)
        alone = cross[: own.shape[0]]
        unlike = max(1.0 - float(alone @ among @ alone) / whole, 0.0) if whole else 0.0
        parallel = np.abs(cross[: own.shape[0]]) / sizes
        nearest = names[int(np.argmax(parallel))] if parallel.size else ""
        told.append(Shown(response.element, left, unlike, nearest))
    return told
