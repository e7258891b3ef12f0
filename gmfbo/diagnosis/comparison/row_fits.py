"""Fits of one row of the ledger: where each begins, and what it may not leave."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby

import numpy as np

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted, elements_of
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.moves import Element, Move
from gmfbo.diagnosis.comparison.numbers import AT_THE_END, SAME
from gmfbo.diagnosis.comparison.priors import coordinates_of, priors_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.fitting.hypothesis import Hypothesis
from gmfbo.physics import CATALOGUE

Rows = Mapping[frozenset[str], Fitted]

_SHARES = (1.0, 0.3, 0.05)  # of a start: a smaller size is nearer to the row without it
_PART = 0.3  # of the linear start, of what a law has beside its limit
_NO_WORSE = 20.0  # of chi2: what priors may ask for
_BEYOND_NOISE = 4.0  # standard deviations of the whitened square


class RowFits:
    """Fits through a problem's simulators.

    Parameters
    ----------
    problem : Problem
        Recordings and simulators.
    noise_of : callable (frozenset of str) -> HeardNoise or None
        Under which a row is fitted, by what it adds to the twin.
    rival : float
        [nats] Cost of the best row: what stays far behind it is not searched on.
    known : iterable of Fitted
        Rows that know how far their quantities have to be moved.
    """

    def __init__(
        self,
        problem: Problem,
        noise_of: Callable[[frozenset[str]], HeardNoise | None],
        rival: float = np.inf,
        known: Iterable[Fitted] = (),
    ) -> None:
        self._problem, self._noise_of, self._rival = problem, noise_of, rival
        self._steps: dict[str, float] = {}
        for row in known:
            self._steps = {**row.hypothesis.setting.difference_steps, **self._steps}

    def _search(
        self, whitening: Whitening, hypothesis: Hypothesis, freed: Sequence[str]
    ) -> ModeSearch:
        hypothesis = hypothesis.moved_by({**self._steps, **hypothesis.setting.difference_steps})
        noise = self._noise_of(elements_of(hypothesis, freed))
        return ModeSearch(self._problem, whitening, hypothesis, freed, noise)

    def with_moves(
        self, ledger: Ledger, about: Fitted, moves: Sequence[Move], best: Fitted | None = None
    ) -> dict[frozenset[str], Fitted]:
        """Rows of a ledger, with those that moves from one of them lead to.

        Parameters
        ----------
        ledger : Ledger
            Rows, and the whitening under which they are fitted.
        about : Fitted
            Where the moves begin.
        moves : sequence of Move
            At their starts.
        best : Fitted, optional
            What a row shares with this one starts at the values there.
        """
        rows, left = dict(ledger.rows), list(moves)
        side_by_side = self._problem.simulations.side_by_side
        while left:
            # A law begins as its limit, which is fitted before.
            names = {move.element.name for move in left}
            now = [move for move in left if not _contained(move.element) & names] or left
            moved = partial(self._moved, ledger, about, best, dict(rows))
            for found in side_by_side(moved, now):
                if found is not None:
                    rows[found.elements] = found
            left = [move for move in left if move not in now]
        return rows

    def _moved(
        self, ledger: Ledger, about: Fitted, best: Fitted | None, rows: Rows, move: Move
    ) -> Fitted | None:
        limit, found = limit_of(move.element, about, rows), None
        if limit is not None:
            found = self._from_limit(ledger.whitening, about, move.element, limit, _PART)
        if found is not None:
            return found
        near = about if best is None else _with_values_of(about, best)
        left = chi(about, ledger.whitening)
        elements = (move.element, *move.others)
        tried = [self._no_worse(ledger.whitening, near, element, left) for element in elements]
        ended = [row for row in tried if row is not None]
        return min(ended, key=lambda row: cost(row, ledger.whitening), default=None)

    def without(
        self, whitening: Whitening, row: Fitted, name: str, iterations: int
    ) -> Fitted | None:
        """Fit a row without one of its elements.

        Parameters
        ----------
        whitening : Whitening
            Under which it is fitted.
        row : Fitted
            Where the fit begins.
        name : str
            The element.
        iterations : int
            Most steps.
        """
        less = lacking(row, name)
        search = self._search(whitening, less.hypothesis, less.freed)
        return search.fitted(
            row.parameters, row.nuisances, iterations=iterations, near=row, rival=self._rival
        )

    def again(self, whitening: Whitening, row: Fitted, fitted: Rows) -> Fitted:
        """Fit a row again under a whitening, from its limit where that leaves less by now.

        Parameters
        ----------
        whitening : Whitening
            Under which it is fitted.
        row : Fitted
            As it was.
        fitted : mapping of frozenset of str to Fitted
            Rows that were fitted under it.
        """
        for candidate in row.hypothesis.effects:
            element, about = Element(candidate=candidate), lacking(row, candidate.effect)
            limit = limit_of(element, about, fitted)
            if limit is not None and chi(row, whitening) > chi(limit, whitening) + _NO_WORSE:
                # What it has beside its limit did harm: it begins with next to nothing of it.
                found = self._from_limit(whitening, about, element, limit, _SHARES[-1])
                if found is not None:
                    return found
        return self._search(whitening, row.hypothesis, row.freed).again(row, rival=self._rival)

    def all_again(
        self, whitening: Whitening, rows: Rows, stale: Collection[frozenset[str]], fitted: Rows
    ) -> dict[frozenset[str], Fitted]:
        """Fit several rows again, those with fewer limits first.

        Parameters
        ----------
        whitening : Whitening
            Under which they are fitted.
        rows : mapping of frozenset of str to Fitted
            As they were.
        stale : collection of frozenset of str
            Those to fit.
        fitted : mapping of frozenset of str to Fitted
            Rows that were fitted under the whitening.
        """
        found: dict[frozenset[str], Fitted] = {}
        for _, group in groupby(sorted(stale, key=limits_in), key=limits_in):
            now, known = sorted(group, key=sorted), {**fitted, **found}
            again = partial(self._again, whitening, rows, known)
            found |= zip(now, self._problem.simulations.side_by_side(again, now), strict=True)
        return found

    def _again(
        self, whitening: Whitening, rows: Rows, fitted: Rows, elements: frozenset[str]
    ) -> Fitted:
        return self.again(whitening, rows[elements], fitted)

    def to_the_end(self, whitening: Whitening, row: Fitted) -> Fitted:
        """A fit whose values are told, searched on until a step promises next to nothing."""
        return self._search(whitening, row.hypothesis, row.freed).again(row, settled=AT_THE_END)

    def _from_limit(
        self, whitening: Whitening, about: Fitted, element: Element, limit: Fitted, share: float
    ) -> Fitted | None:
        """Fit of one element more that begins as a limit of its law; None where it ends worse.

        A law that holds another as its limit is never worse than that one.
        """
        near = _with_values_of(about, limit)
        started = element.beginning_as(limit.hypothesis.effects, near.hypothesis, share)
        hypothesis = started.added_to(near.hypothesis)
        search = self._search(whitening, hypothesis, about.freed)
        found = search.fitted(near.parameters, near.nuisances, near=limit, rival=self._rival)
        if found is None or chi(found, whitening) > chi(limit, whitening) + _NO_WORSE:
            return None
        return found

    def _no_worse(
        self, whitening: Whitening, about: Fitted, element: Element, before: float
    ) -> Fitted | None:
        """Fit of one element more that leaves no more than the row without it; else None."""
        freed = about.freed if element.freed is None else (*about.freed, element.freed.name)
        starts = []
        sizes = dict.fromkeys(element.sizes(about.hypothesis), 0.0)
        for share in _SHARES if element.can_shrink(about.hypothesis) else _SHARES[:1]:
            tried = element.moved(share, sizes, about.hypothesis)
            search = self._search(whitening, tried.added_to(about.hypothesis), freed)
            start = tried.start(about.parameters)
            at = search.begun(start, about.nuisances, about)
            if at is not None:
                starts.append((search.cost(at), at))
        known: Mapping[str, float] = {}
        for _, at in sorted(starts, key=lambda one: one[0]):
            # How far a quantity has to be moved is much the same at each start.
            steps = {**at.hypothesis.setting.difference_steps, **known}
            search = self._search(whitening, at.hypothesis.moved_by(steps), freed)
            found = search.fitted_from(at, rival=self._rival)
            if chi(found, whitening) <= before + _NO_WORSE:
                return found
            known = found.hypothesis.setting.difference_steps
        return None


def cost(row: Fitted, whitening: Whitening) -> float:
    """[nats] Negative log density of the recordings and a row's values."""
    return 0.5 * chi(row, whitening) - row.log_prior


def under_own_noise(
    ledger: Ledger,
    fits: Callable[[Ledger], RowFits],
    noise: Mapping[frozenset[str], HeardNoise | None],
) -> Ledger:
    """A ledger with rows under their own noise, those that leave less under it.

    Parameters
    ----------
    ledger : Ledger
        Under whose whitening they are fitted again.
    fits : callable (Ledger) -> RowFits
        Fits rows of a ledger.
    noise : mapping of frozenset of str to HeardNoise or None
        By row.
    """
    told = {elements: heard for elements, heard in noise.items() if heard is not None}
    if not told:
        return ledger
    whitening = ledger.whitening
    rows = ledger.rows | fits(ledger).all_again(whitening, ledger.rows, told.keys(), ledger.rows)
    tried = replace(ledger, own_noise={**ledger.own_noise, **told})
    again = fits(tried).all_again(whitening, rows, told.keys(), rows)
    left = {e: chi(row, whitening) for e, row in rows.items() if e in told}
    new = {e: row for e, row in again.items() if chi(row, whitening) < left[e] - SAME}
    own = {**ledger.own_noise, **{e: told[e] for e in new}}
    return replace(ledger, rows=rows | new, own_noise=own)


def chi(row: Fitted, whitening: Whitening) -> float:
    """Whitened square of what a row leaves."""
    return row.beside_own_parts(whitening).square(row.residual)


def log_likelihood(row: Fitted, whitening: Whitening) -> float:
    """[nats] Log density of the recordings at a row's values, but for a constant."""
    own = row.beside_own_parts(whitening)
    logs = sum(float(np.sum(part)) for part in own.log_determinants)
    return -0.5 * (own.square(row.residual) + logs)


def beyond_noise(row: Fitted, whitening: Whitening) -> float:
    """Whitened square of what a row leaves, less that of noise."""
    return chi(row, whitening) - values_in(row)


def values_in(row: Fitted) -> int:
    """Number of values that are compared: the whitened square of noise."""
    return sum(own.size for own in row.residual)


def is_more_than_noise(beyond: float, values: float) -> bool:
    """Whether noise in so many values would hardly leave so large a square beyond its own."""
    return bool(beyond > _BEYOND_NOISE * np.sqrt(2.0 * values))


def limits_in(elements: frozenset[str]) -> int:
    """Number of simpler laws that the laws of a row hold: those with fewer are fitted first."""
    return sum(len(CATALOGUE[name].contains) for name in elements if name in CATALOGUE)


def limit_of(element: Element, about: Fitted, rows: Rows) -> Fitted | None:
    """Row with a limit of an element's law in its place, beside what another row holds.

    Parameters
    ----------
    element : Element
        The larger law; nothing else has a limit.
    about : Fitted
        The row that it is added to.
    rows : mapping of frozenset of str to Fitted
        Among which the limit is looked for.
    """
    if element.candidate is None or not element.candidate.law.as_limit:
        return None
    among = [rows.get(about.elements | {name}) for name in element.candidate.law.contains]
    return next((row for row in among if row is not None), None)


def begun_as_larger(ledger: Ledger, best: Fitted) -> list[tuple[Fitted, list[Move]]]:
    """Limits of a row's laws at the values that these have, where their own fits leave far more.

    A fit that began elsewhere may have ended in another hollow, or have been given up.

    Parameters
    ----------
    ledger : Ledger
        Rows, and the whitening under which they are fitted.
    best : Fitted
        The row.
    """
    left = chi(best, ledger.whitening) + _NO_WORSE
    plans: list[tuple[Fitted, list[Move]]] = []
    for larger in best.hypothesis.at(best.x).effects:
        about = ledger.rows.get(best.elements - {larger.effect})
        if about is None:
            continue
        for name in larger.law.contains:
            row = ledger.rows.get(about.elements | {name})
            limit = larger.as_limit(name, best.hypothesis.setting.excitation)
            if row is not None and limit is not None and chi(row, ledger.whitening) > left:
                plans.append((about, [Move(Element(candidate=limit), np.inf)]))
    return plans


def _contained(element: Element) -> set[str]:
    return set() if element.candidate is None else set(element.candidate.law.contains)


def lacking(row: Fitted, name: str) -> Fitted:
    """A row without one of its elements, not fitted.

    Parameters
    ----------
    row : Fitted
        Any.
    name : str
        One of its elements.
    """
    setting, gone = row.hypothesis.setting, name.removeprefix("parameter:")
    freed = tuple(f for f in row.freed if f != gone)
    if len(freed) < len(row.freed):
        setting = replace(setting, uncertain=tuple(u for u in setting.uncertain if u.name != gone))
    effects = tuple(c for c in row.hypothesis.effects if c.effect != name)
    hypothesis = replace(row.hypothesis, setting=setting, effects=effects)
    priors, x = priors_of(hypothesis, freed), hypothesis.start(row.parameters)
    u = coordinates_of(priors, x)
    own = row.own_of(hypothesis.names)
    return replace(row, hypothesis=hypothesis, freed=freed, priors=priors, u=u, own=own)


def _with_values_of(row: Fitted, best: Fitted) -> Fitted:
    """A row with its effects, parameters and nuisances at the values of a larger one."""
    known = {c.effect: c for c in best.hypothesis.effects}
    effects = tuple(known.get(c.effect, c) for c in row.hypothesis.effects)
    hypothesis = replace(row.hypothesis, effects=effects)
    x = hypothesis.start({**row.parameters, **best.parameters})
    if not x.size:
        return row
    priors = priors_of(hypothesis, row.freed)  # the larger one may hold more lines of an effect
    u = coordinates_of(priors, x)
    own = best.own_of(hypothesis.names)
    return replace(
        row, hypothesis=hypothesis, priors=priors, u=u, nuisances=best.nuisances, own=own
    )
