"""The search: best first over a ledger of fitted hypotheses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import factorial, log

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from gmfbo.diagnosis.comparison.evidence import weightings
from gmfbo.diagnosis.comparison.fit_noise import FitNoise
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.heard_noise import HeardNoise
from gmfbo.diagnosis.comparison.hearing.sensed_noise import heard_about
from gmfbo.diagnosis.comparison.inadequacy import BesideInadequacy, with_inadequacy
from gmfbo.diagnosis.comparison.ledger import Ledger, Scored
from gmfbo.diagnosis.comparison.modes.posterior_mode import ModeSearch
from gmfbo.diagnosis.comparison.moves import Element, Move, Response, ranked, responses
from gmfbo.diagnosis.comparison.next_moves import plans_of
from gmfbo.diagnosis.comparison.numbers import (
    FIXED_SHARE,
    LEAST_GAIN,
    PRIOR_OF_COUNT,
    SAME,
)
from gmfbo.diagnosis.comparison.port_kernels import PortKernels
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.row_fits import (
    RowFits,
    beyond_noise,
    chi,
    cost,
    is_more_than_noise,
    limits_in,
    log_likelihood,
    under_own_noise,
    values_in,
)
from gmfbo.physics import CATALOGUE

Array = NDArray[np.float64]

_FIRST_FITS, _FREED_FITS, _QUIET_FITS = 6, 4, 3
_ANYWAY = 2  # first fits of the moves that gain most, however little that is
_MUCH = 3.0  # times the level about which nobody cares
_WITHOUT = 4  # points of a fit without one of the best elements: most are far worse
_LEVELS = 4  # most rounds of levels and rows
_KEPT = 5  # best rows that are fitted again under new levels
_HEARINGS = 3  # most rounds of rows and the noise that the best one tells
_COMPARED = 8  # best rows of which each is seen under its own inadequacy


@dataclass(frozen=True, eq=False)
class Search:
    """What a search needs.

    Attributes
    ----------
    elements : tuple of Element
        Effects at their starts, and fixed parameters that can be freed.
    noise : FitNoise
        Recordings, simulators, and what is noise about a fit.
    tolerance : float
        [FMU's unit] Mean of the prior of the size of a smooth inadequacy at the torque port.
    kernels_at : callable (Fitted) -> PortKernels
        Measures the paths.
    log : callable (str)
        Told what happens.
    """

    elements: tuple[Element, ...]
    noise: FitNoise
    tolerance: float
    kernels_at: Callable[[Fitted], PortKernels]
    log: Callable[[str], None] = field(default=lambda line: None)

    @cached_property
    def _beside(self) -> BesideInadequacy:
        return BesideInadequacy(self.problem)

    @property
    def problem(self) -> Problem:
        """Recordings and simulators."""
        return self.noise.problem

    def _fits(self, ledger: Ledger) -> RowFits:
        rows = (row for row in ledger.rows.values() if row.heard is ledger.noise_of(row.elements))
        best = min((cost(row, ledger.whitening) for row in rows), default=np.inf)
        return RowFits(self.problem, ledger.noise_of, best, ledger.rows.values())

    def opened(self, first: Fitted) -> Ledger:
        """Ledger with the twin as it is, its uncertain parameters refitted."""
        kernels = self.kernels_at(first)
        base, levels, noise = first, None, self.noise
        errors = noise.errors(base, kernels, None)
        for _ in range(2):
            levels = noise.levels(base, kernels, levels, errors)
            errors = noise.errors(base, kernels, levels)
            levels, errors = noise.likelier(base, kernels, [levels], errors)
            whitening = noise.scaled(base, kernels, levels, errors)
            search = ModeSearch(self.problem, whitening, first.hypothesis)
            found = search.fitted(base.parameters, base.nuisances)
            assert found is not None
            base = found
        kernels = self.kernels_at(base)
        levels = noise.levels(base, kernels, levels, errors)
        whitening = noise.scaled(base, kernels, levels, errors)
        self.log(f"base {base.parameters} {levels}")
        return Ledger({frozenset(): base}, kernels, levels, whitening, levels, errors)

    def searched(self, ledger: Ledger) -> tuple[Ledger, Scored]:
        """Best first, until nothing gains."""
        base = ledger.rows[frozenset()]
        found = responses(self.problem, base, self.elements)
        ledger = replace(ledger, responses=tuple(found))
        moves = ranked(ledger.whitening, base, found)
        self.log("moves " + ", ".join(f"{m.element.name} {m.gain:.1f}" for m in moves[:10]))
        moves = [m for k, m in enumerate(moves) if k < _ANYWAY or m.gain > LEAST_GAIN]
        effects = [m for m in moves if m.element.candidate is not None][:_FIRST_FITS]
        effects += self._limits_of(effects, moves)
        effects.sort(key=lambda m: limits_in(frozenset({m.element.name})))
        freed = [m for m in moves if m.element.freed is not None][:_FREED_FITS]
        rows = self._fits(ledger).with_moves(ledger, base, [*effects, *freed])
        ledger, scored = self._settled(replace(ledger, rows=rows))
        if self._is_inadequate(ledger, scored):
            ledger, scored = self._settled(self._by_noise_alone(ledger, base, found))
        ledger, scored = self._heard(ledger, scored)
        seen: set[frozenset[str]] = set()
        for _ in range(2 * len(PRIOR_OF_COUNT)):
            before, ahead = scored.best, scored.ahead - seen
            seen |= ahead
            ledger = self._with_fewer(ledger, before)
            plans = plans_of(ledger, scored, found, ahead, self.log)
            if not plans:
                break
            best = ledger.rows[before]
            for about, chosen in plans:
                near = about if best.elements < about.elements else best
                rows = self._fits(ledger).with_moves(ledger, about, chosen, near)
                ledger = replace(ledger, rows=rows)
            ledger, scored = self._settled(ledger)
            if scored.best != before:
                ledger, scored = self._heard(ledger, scored)
        return ledger, self.scored(ledger)

    def _limits_of(self, effects: Sequence[Move], moves: Sequence[Move]) -> list[Move]:
        """Moves to the simpler laws of some effects: what is larger always gains as much."""
        known = {move.element.name for move in effects}
        limits = {name for e in known for name in CATALOGUE[e].contains} - known
        return [move for move in moves if move.element.name in limits]

    def _by_noise_alone(self, ledger: Ledger, base: Fitted, found: Sequence[Response]) -> Ledger:
        """Add the moves that gain most where nothing but noise is forgiven.

        What the twin lacks is first taken for an inadequacy, beside which a law may hardly show.
        """
        whitening = self.noise.cared_about(base, ledger)
        alone = replace(ledger, rows={}, whitening=whitening)
        moves = ranked(whitening, base, found)
        self.log(
            "by noise alone " + ", ".join(f"{m.element.name} {m.gain:.1f}" for m in moves[:10])
        )
        moves = moves[:_QUIET_FITS]
        rows = dict(ledger.rows)
        for elements, row in self._fits(alone).with_moves(alone, base, moves).items():
            if elements not in rows or chi(row, whitening) < chi(rows[elements], whitening):
                rows[elements] = row
        return replace(ledger, rows=rows)

    def _is_inadequate(self, ledger: Ledger, scored: Scored) -> bool:
        """Whether the best row leaves clearly more than noise of loop and logger."""
        if "torque" not in self.noise.cared:
            return False
        best = ledger.rows[scored.best]
        beyond = beyond_noise(best, self.noise.quiet(best, ledger))
        return is_more_than_noise(beyond, values_in(best))

    def _with_fewer(self, ledger: Ledger, elements: frozenset[str]) -> Ledger:
        """Rows that lack one element of a row, those that were not fitted before too."""
        rows = dict(ledger.rows)
        for name in elements:
            if elements - {name} not in rows:
                found = self._fits(ledger).without(ledger.whitening, rows[elements], name, _WITHOUT)
                if found is not None:
                    rows[found.elements] = found
        return replace(ledger, rows=rows)

    def _settled(self, ledger: Ledger) -> tuple[Ledger, Scored]:
        """Levels at the best row, the best rows fitted again under them."""
        for _ in range(_LEVELS):
            leading = self._leading(ledger)
            ledger = self._levelled(ledger, leading)
            ledger, scored = self._current(ledger, {leading})
            if scored.best == leading:
                break
        return ledger, scored

    def _levelled(self, ledger: Ledger, leading: frozenset[str]) -> Ledger:
        """Levels and one row, fitted in turn until the levels stay.

        What a law leaves is taken for an inadequacy at first, under which it is fitted loosely.
        """
        row, kernels = ledger.rows[leading], self.kernels_at(ledger.rows[leading])
        for _ in range(_LEVELS):
            self.log(f"levels about {sorted(leading)}")
            before = ledger.levels
            levels = self.noise.levels(row, kernels, before, ledger.errors)
            errors = self.noise.errors(row, kernels, levels)
            levels, errors = self.noise.likelier(row, kernels, [levels, before], errors)
            errors = self.noise.with_own_parts(row, kernels, levels, errors)
            whitening = self.noise.scaled(row, kernels, levels, errors)
            ledger = replace(
                ledger, kernels=kernels, levels=levels, whitening=whitening, errors=errors
            )
            row = RowFits(self.problem, ledger.noise_of).again(whitening, row, {})
            ledger = replace(ledger, rows={**ledger.rows, leading: row})
            cared = self.noise.cared.keys() & levels.ports.keys()
            fallen = [before.missing(p) / levels.missing(p) for p in cared]
            if max(fallen, default=1.0) < _MUCH:
                break
        return ledger

    def _current(self, ledger: Ledger, asked: set[frozenset[str]]) -> tuple[Ledger, Scored]:
        """Fit rows again under the ledger's whitening until the best of them all are."""
        rows, done = dict(ledger.rows), set[frozenset[str]]()
        while True:
            scored = self.scored(replace(ledger, rows=rows), weighted=False)
            order = np.argsort(-scored.log_evidences.mean(1))
            stale = ({scored.elements[i] for i in order[:_KEPT]} | asked) - done
            if not stale:
                return replace(ledger, rows=rows), scored
            known = {e: rows[e] for e in done}
            rows |= self._fits(ledger).all_again(ledger.whitening, rows, stale, known)
            done |= stale

    def _heard(self, ledger: Ledger, scored: Scored) -> tuple[Ledger, Scored]:
        """Best rows fitted again under the noise that the best one says the controller read.

        As long as the recordings get likelier: where noise decides when an axis leaves its
        friction, linear paths tell that noise wrongly. Then the rivals of the best row, each under
        the noise that it says itself, where it leaves clearly less.
        """
        if "sensor" not in ledger.kernels.simulated.keys() & ledger.levels.ports.keys():
            return ledger, scored
        for _ in range(_HEARINGS):
            # What leads by what it leaves itself may be another row than the best under its levels.
            rows = dict.fromkeys([self._leading(ledger), scored.best])
            likelier = (self._likelier_hearing(ledger, row) for row in rows)
            tried = next((one for one in likelier if one is not None), None)
            if tried is None:
                break
            ledger, scored = self._settled(tried)
        rivals = {e: self._heard_by(ledger, e) for e in scored.rivals_to_hear(ledger)}
        before, ledger = scored.best, under_own_noise(ledger, self._fits, rivals)
        scored = self.scored(ledger, weighted=False)
        return (ledger, scored) if scored.best == before else self._settled(ledger)

    def _likelier_hearing(self, ledger: Ledger, row: frozenset[str]) -> Ledger | None:
        """A row, and its levels, under the noise that it says itself; None if no likelier so."""
        heard = self._heard_by(ledger, row)
        if heard is None:
            return None
        own = {**ledger.own_noise, row: heard}
        tried = self._levelled(replace(ledger, noise=heard, own_noise=own), row)
        tried = self._levelled(tried, row)  # errors are now those of what it has not heard
        was, now = (log_likelihood(one.rows[row], one.whitening) for one in (ledger, tried))
        return tried if now > was else None

    def _heard_by(self, ledger: Ledger, elements: frozenset[str]) -> HeardNoise | None:
        """Noise that a row says the controller read; None where it changes nothing there."""
        self.log(f"noise heard about {sorted(elements)}")
        row, levels = ledger.rows[elements], ledger.levels
        kernels = self.kernels_at(row)
        left = ledger.errors.taken_out(self.problem, row, kernels, levels)
        heard = heard_about(self.problem, row, left, kernels, levels)
        change = heard.change_of(self.problem, row.hypothesis, row.x, row.own_values, row.values)
        return None if ledger.whitening.square(change) < SAME else heard

    def _leading(self, ledger: Ledger) -> frozenset[str]:
        """Row of the largest evidence, each under the inadequacy that it leaves itself."""
        most, leading = -np.inf, frozenset[str]()
        for elements in self._unbeaten(ledger):
            value = self.evidence_alone(ledger.rows[elements], ledger)
            if value > most:
                most, leading = value, elements
        return leading

    def evidence_alone(self, row: Fitted, ledger: Ledger) -> float:
        """[nats] Log evidence of a row under the inadequacy that it leaves itself.

        Parameters
        ----------
        row, ledger
            As of `FitNoise.alone`.
        """
        own, alone = self.noise.alone(row, ledger), BesideInadequacy(self.problem)
        return float(self.scored(own, weighted=False, beside=alone).log_evidences.mean())

    def _unbeaten(self, ledger: Ledger) -> list[frozenset[str]]:
        """Best rows that no better one also beats by noise alone: others lead under no levels."""
        scored = self.scored(ledger, weighted=False)
        order = np.argsort(-scored.log_evidences.mean(1))[:_COMPARED]
        whitening = self.noise.quiet(ledger.rows[scored.elements[order[0]]], ledger)
        left = np.inf
        found: list[frozenset[str]] = []
        for elements in [scored.elements[i] for i in order]:
            own = chi(ledger.rows[elements], whitening)
            if own < left:
                left = own
                found.append(elements)
        return found

    def scored(
        self, ledger: Ledger, *, weighted: bool = True, beside: BesideInadequacy | None = None
    ) -> Scored:
        """Beliefs in all rows."""
        beside = beside or self._beside
        extra, weights, logs, sizes = beside.begin(ledger), None, [], []
        for row in ledger.rows.values():
            inner = beside.grams(row)
            if weights is None:
                n = len(inner.squares)
                weights = weightings(n) if weighted else np.ones((1, n))
            own, size = with_inadequacy(row, inner, weights, extra, self.tolerance)
            logs.append(own + self.log_prior(row.elements))
            sizes.append(float(size.mean()))
        table = np.stack(logs)
        beliefs = softmax(table, axis=0).mean(1)
        return Scored(tuple(ledger.rows), table, beliefs, np.array(sizes))

    def log_prior(self, elements: frozenset[str]) -> float:
        """[nats] Of a hypothesis, by what it adds to the twin."""
        effects = max(len({e.name for e in self.elements if e.candidate is not None}), 1)
        fixed = len({e.name for e in self.elements if e.freed is not None})
        count = min(len(elements), len(PRIOR_OF_COUNT) - 1)
        total = log(PRIOR_OF_COUNT[count]) + log(factorial(count))
        for name in elements:
            if name.startswith("parameter:"):
                total += log(FIXED_SHARE / fixed)
            else:
                total += log((1.0 - (FIXED_SHARE if fixed else 0.0)) / effects)
        return total
