"""The search: best first over a ledger of fitted hypotheses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import factorial, log

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from gmfbo.diagnosis.comparison.evidence import grams, weightings
from gmfbo.diagnosis.comparison.inadequacy import inadequacy_columns, with_inadequacy
from gmfbo.diagnosis.comparison.moves import Element, Move, Response, ranked, responses
from gmfbo.diagnosis.comparison.noise_places import Levels, blocks_of, estimated, inadequate
from gmfbo.diagnosis.comparison.numbers import (
    FIXED_SHARE,
    LEAST_GAIN,
    PRIOR_OF_COUNT,
)
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.posterior_mode import Fitted, ModeSearch
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.whitener import Whitening, segment_whitener
from gmfbo.physics import CATALOGUE

Array = NDArray[np.float64]

_FIRST_FITS, _LATER_FITS, _FREED_FITS = 6, 3, 4
_SHARES = (1.0, 0.3, 0.05)  # of a start: a smaller size is nearer to the row without it
_NO_WORSE = 20.0  # of chi2: what priors may ask for
_KEPT = 5  # best rows that are fitted again under new levels
_COMPARED = 8  # best rows of which each is seen under its own inadequacy


@dataclass(frozen=True, eq=False)
class Ledger:
    """Fitted hypotheses and the noise under which they compete.

    Attributes
    ----------
    rows : mapping of frozenset to Fitted
        By what they add to the twin.
    kernels : PortKernels
        Paths from the ports to the signals.
    levels : Levels
        Of noise, and of the inadequacy that all rows share.
    whitening : Whitening
        By these levels.
    """

    rows: dict[frozenset[str], Fitted]
    kernels: PortKernels
    levels: Levels
    whitening: Whitening


@dataclass(frozen=True, eq=False)
class Scored:
    """Beliefs in the rows of a ledger.

    Attributes
    ----------
    elements : tuple of frozenset
        Of each row.
    log_evidences : ndarray, shape (n_rows, n_weightings)
        With the prior of the hypothesis.
    beliefs : ndarray, shape (n_rows,)
        Mean over the weightings.
    sizes : ndarray, shape (n_rows,)
        [FMU's unit of the torque port] Of the inadequacy beside each row.
    """

    elements: tuple[frozenset[str], ...]
    log_evidences: Array
    beliefs: Array
    sizes: Array

    @property
    def best(self) -> frozenset[str]:
        """Row of the largest belief."""
        return self.elements[int(np.argmax(self.log_evidences.mean(1)))]


@dataclass(frozen=True, eq=False)
class Search:
    """What a search needs beside the problem.

    Attributes
    ----------
    problem : Problem
        Recordings and simulators.
    elements : tuple of Element
        Effects at their starts, and fixed parameters that can be freed.
    least : Levels
        Below which no level is looked for.
    cared : mapping of str to float
        [FMU's unit] By port, the level of an inadequacy below which nobody cares.
    tolerance : float
        [FMU's unit] Mean of the prior of the size of a smooth inadequacy at the torque port.
    kernels_at : callable (Fitted) -> PortKernels
        Measures the paths.
    log : callable (str)
        Told what happens.
    """

    problem: Problem
    elements: tuple[Element, ...]
    least: Levels
    cared: dict[str, float]
    tolerance: float
    kernels_at: Callable[[Fitted], PortKernels]
    log: Callable[[str], None] = field(default=lambda line: None)

    def levels_at(self, fitted: Fitted, kernels: PortKernels, near: Levels | None = None) -> Levels:
        """Levels of noise and inadequacy about a fit."""
        problem = self.problem
        rates = problem.rates(fitted.values)
        free = [f"port:{p}" for p in self.least.ports]
        free += [f"own:{name}" for name in self.least.own]
        if any(r.any() for r in rates):
            free.append("jitter")
        blocks = blocks_of(problem.segments, fitted.residual, rates)
        levels = estimated(kernels, blocks, self.least, free, near)
        return self._inadequacy_at(fitted, kernels, levels)

    def _inadequacy_at(self, fitted: Fitted, kernels: PortKernels, levels: Levels) -> Levels:
        """These levels of noise, with those of the inadequacy that a fit leaves."""
        problem = self.problem
        rates = problem.rates(fitted.values)
        return inadequate(kernels, problem.segments, fitted.residual, rates, levels, self.cared)

    def whitening_at(self, fitted: Fitted, kernels: PortKernels, levels: Levels) -> Whitening:
        """Whitening by these levels."""
        rates = self.problem.rates(fitted.values)
        return Whitening(
            tuple(
                segment_whitener(segment, kernels, levels, rate)
                for segment, rate in zip(self.problem.segments, rates, strict=True)
            )
        )

    def opened(self, first: Fitted) -> Ledger:
        """Ledger with the twin as it is, its uncertain parameters refitted."""
        kernels = self.kernels_at(first)
        base, levels = first, None
        for _ in range(2):
            levels = self.levels_at(base, kernels, levels)
            whitening = self.whitening_at(base, kernels, levels)
            search = ModeSearch(self.problem, whitening, first.hypothesis)
            found = search.fitted(base.parameters, base.nuisances)
            assert found is not None
            base = found
        kernels = self.kernels_at(base)
        levels = self.levels_at(base, kernels, levels)
        whitening = self.whitening_at(base, kernels, levels)
        self.log(f"base {base.parameters} {levels}")
        return Ledger({frozenset(): base}, kernels, levels, whitening)

    def searched(self, ledger: Ledger) -> tuple[Ledger, Scored]:
        """Best first, until nothing gains."""
        base = ledger.rows[frozenset()]
        found = responses(self.problem, base, self.elements)
        moves = ranked(ledger.whitening, base, found)
        self.log("moves " + ", ".join(f"{m.element.name} {m.gain:.1f}" for m in moves[:10]))
        effects = [m for m in moves if m.element.candidate is not None][:_FIRST_FITS]
        freed = [m for m in moves if m.element.freed is not None][:_FREED_FITS]
        ledger = self._fitted(ledger, base, [*effects, *freed])
        ledger, scored = self._settled(ledger)
        for _ in range(2 * len(PRIOR_OF_COUNT)):
            before = scored.best
            ledger = self._with_fewer(ledger, before)
            plans = self._next(ledger, scored, found)
            if not plans:
                break
            for about, chosen in plans:
                ledger = self._fitted(ledger, about, chosen)
            ledger, scored = self._settled(ledger)
            if scored.best == before:
                break
        return ledger, self.scored(ledger)

    def _next(
        self, ledger: Ledger, scored: Scored, found: Sequence[Response]
    ) -> list[tuple[Fitted, list[Move]]]:
        """Moves from the best row: one element more, and one in the place of another."""
        best = ledger.rows[scored.best]
        plans = []
        origins = [best] if len(best.elements) < len(PRIOR_OF_COUNT) - 1 else []
        fewer = [ledger.rows.get(best.elements - {name}) for name in best.elements]
        origins += [row for row in fewer if row is not None and row.elements]
        for about in origins:
            moves = ranked(ledger.whitening, about, found)
            self.log(
                f"beside {sorted(about.elements)}: "
                + ", ".join(f"{m.element.name} {m.gain:.1f}" for m in moves[:6])
            )
            fitting = [m for m in moves if not _one_holds_the_other(m.element.name, about.elements)]
            chosen = [m for m in fitting if m.gain > LEAST_GAIN][:_LATER_FITS]
            # A law that was found is tried as its limit as well.
            limits = {n for e in best.elements if e in CATALOGUE for n in CATALOGUE[e].contains}
            chosen += [m for m in fitting if m.element.name in limits and m not in chosen]
            chosen = [m for m in chosen if about.elements | {m.element.name} not in ledger.rows]
            if chosen:
                plans.append((about, chosen))
        return plans

    def _with_fewer(self, ledger: Ledger, elements: frozenset[str]) -> Ledger:
        """Rows that lack one element of a row, those that were not fitted before too."""
        rows = dict(ledger.rows)
        for name in elements:
            if elements - {name} not in rows:
                found = self._without(ledger, rows[elements], name)
                if found is not None:
                    rows[found.elements] = found
        return replace(ledger, rows=rows)

    def _without(self, ledger: Ledger, row: Fitted, name: str) -> Fitted | None:
        """The row without one of its elements, fitted again."""
        effects = tuple(c for c in row.hypothesis.effects if c.effect != name)
        gone = name.removeprefix("parameter:")
        freed = tuple(f for f in row.freed if f != gone)
        setting = row.hypothesis.setting
        if len(freed) < len(row.freed):
            kept = tuple(u for u in setting.uncertain if u.name != gone)
            setting = replace(setting, uncertain=kept)
        hypothesis = replace(row.hypothesis, setting=setting, effects=effects)
        search = ModeSearch(self.problem, ledger.whitening, hypothesis, freed)
        return search.fitted(row.parameters, row.nuisances)

    def _fitted(self, ledger: Ledger, about: Fitted, moves: Sequence[Move]) -> Ledger:
        rows = dict(ledger.rows)
        for move in moves:
            freed = about.freed
            if move.element.freed is not None:
                freed = (*freed, move.element.freed.name)
            found = self._no_worse(ledger, about, move.element, freed)
            if found is not None:
                rows[found.elements] = found
        return replace(ledger, rows=rows)

    def _no_worse(
        self, ledger: Ledger, about: Fitted, element: Element, freed: tuple[str, ...]
    ) -> Fitted | None:
        """Fit of one element more that leaves no more than the row without it; else None."""
        before = _chi(about, ledger.whitening)
        for share in _SHARES:
            tried = element.moved(share, dict.fromkeys(element.sizes(about.hypothesis), 0.0))
            hypothesis = tried.added_to(about.hypothesis)
            search = ModeSearch(self.problem, ledger.whitening, hypothesis, freed)
            found = search.fitted(tried.start(about.parameters), about.nuisances)
            if found is not None and _chi(found, ledger.whitening) <= before + _NO_WORSE:
                return found
            if not element.sizes(about.hypothesis):
                return None
        return None

    def _settled(self, ledger: Ledger) -> tuple[Ledger, Scored]:
        """Levels at the best row, the best rows fitted again under them."""
        for _ in range(2):
            leading = self._leading(ledger)
            best = ledger.rows[leading]
            kernels = self.kernels_at(best)
            levels = self.levels_at(best, kernels, ledger.levels)
            whitening = self.whitening_at(best, kernels, levels)
            ledger = Ledger(dict(ledger.rows), kernels, levels, whitening)
            ledger, scored = self._current(ledger, {frozenset(), leading})
            if scored.best == leading:
                break
        return ledger, scored

    def _current(self, ledger: Ledger, asked: set[frozenset[str]]) -> tuple[Ledger, Scored]:
        """Fit rows again under the ledger's whitening until the best of them all are."""
        rows, done = dict(ledger.rows), set[frozenset[str]]()
        while True:
            scored = self.scored(replace(ledger, rows=rows), weighted=False)
            order = np.argsort(-scored.log_evidences.mean(1))
            stale = ({scored.elements[i] for i in order[:_KEPT]} | asked) - done
            if not stale:
                return replace(ledger, rows=rows), scored
            for elements in stale:
                row = rows[elements]
                search = ModeSearch(self.problem, ledger.whitening, row.hypothesis, row.freed)
                rows[elements] = search.again(row)
            done |= stale

    def _leading(self, ledger: Ledger) -> frozenset[str]:
        """Row of the largest evidence, each under the inadequacy that it leaves itself."""
        scored = self.scored(ledger, weighted=False)
        order = np.argsort(-scored.log_evidences.mean(1))
        most, leading = -np.inf, frozenset[str]()
        for elements in dict.fromkeys([scored.elements[i] for i in order[:_COMPARED]]):
            row = ledger.rows[elements]
            levels = self._inadequacy_at(row, ledger.kernels, ledger.levels)
            own = replace(
                ledger,
                rows={elements: row},
                levels=levels,
                whitening=self.whitening_at(row, ledger.kernels, levels),
            )
            value = float(self.scored(own, weighted=False).log_evidences.mean())
            if value > most:
                most, leading = value, elements
        return leading

    def scored(self, ledger: Ledger, *, weighted: bool = True) -> Scored:
        """Beliefs in all rows."""
        problem = self.problem
        bumps = ledger.whitening(
            inadequacy_columns(problem, ledger.kernels, next(iter(ledger.rows.values())))
        )
        weights, logs, sizes = None, [], []
        for row in ledger.rows.values():
            inner = grams(problem, ledger.whitening, row, bumps)
            if weights is None:
                n = len(inner.squares)
                weights = weightings(n) if weighted else np.ones((1, n))
            own, size = with_inadequacy(row, inner, weights, bumps[0].shape[0], self.tolerance)
            logs.append(own + self._prior(row.elements))
            sizes.append(float(size.mean()))
        table = np.stack(logs)
        beliefs = softmax(table, axis=0).mean(1)
        return Scored(tuple(ledger.rows), table, beliefs, np.array(sizes))

    def _prior(self, elements: frozenset[str]) -> float:
        effects = len({e.name for e in self.elements if e.candidate is not None})
        fixed = len({e.name for e in self.elements if e.freed is not None})
        total = log(PRIOR_OF_COUNT[len(elements)]) + log(factorial(len(elements)))
        for name in elements:
            if name.startswith("parameter:"):
                total += log(FIXED_SHARE / fixed)
            else:
                total += log((1.0 - (FIXED_SHARE if fixed else 0.0)) / effects)
        return total


def _one_holds_the_other(name: str, elements: frozenset[str]) -> bool:
    """Whether an element is a limit of one in a row, or holds one."""
    own = CATALOGUE[name].contains if name in CATALOGUE else ()
    return any(
        other in own or (other in CATALOGUE and name in CATALOGUE[other].contains)
        for other in elements
    )


def _chi(row: Fitted, whitening: Whitening) -> float:
    return sum(float(np.sum(z**2)) for z in whitening(row.residual))
