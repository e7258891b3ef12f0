"""Compare free functions with laws: what is unknown, and which laws stand beside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from gmfbo.diagnosis.comparison.evidence import grams, log_evidences, weightings
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.inadequacy import (
    BesideInadequacy,
    inadequacy_columns,
    through_loop,
    with_inadequacy,
)
from gmfbo.diagnosis.comparison.ledger import Ledger, Scored
from gmfbo.diagnosis.comparison.numbers import NAMED, named_log_odds
from gmfbo.diagnosis.comparison.row_fits import RowFits
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.unknown.curve import FreeFunction
from gmfbo.diagnosis.comparison.unknown.fitted import (
    WORTH,
    Sized,
    WithUnknown,
    begun_as,
    fitted_with,
    of_unit_size,
)
from gmfbo.diagnosis.comparison.unknown.kinds import Kind, kinds
from gmfbo.diagnosis.comparison.whitener import Whitening

Array = NDArray[np.float64]

_TRIED = 2  # kinds that are fitted beside a row: those that a straight line likes best
_LEVELS = 5  # most rounds of a function and the noise beside it
_NAME = "unknown"


@dataclass(frozen=True)
class Unknown:
    """What acts that no law of the library holds.

    Attributes
    ----------
    port : str
        Where it acts: `torque`, `command` or `sensor`.
    against : str
        On what it depends: `position`, `velocity`, `command` or `time` since the start.
    probability : float
        That it is there.
    log_odds : float
        [nats] Against laws alone.
    beside : frozenset of str
        Elements of the best row of laws that are believed beside it.
    function : FreeFunction
        Fitted, with these elements.
    """

    port: str
    against: str
    probability: float
    log_odds: float
    beside: frozenset[str]
    function: FreeFunction


def unknown_beside(search: Search, ledger: Ledger, scored: Scored) -> Unknown | None:
    """Tell what acts that no law holds; None where that is not believed.

    Each row of laws, and the same rows with a free function, stand under the noise that they
    leave themselves. A law that adds nothing beside the function is not beside it. Two laws may
    leave little more than noise of what is none of them: they are asked, too.

    Parameters
    ----------
    search : Search
        The problem.
    ledger : Ledger
        Rows of laws.
    scored : Scored
        Beliefs in them.
    """
    if "torque" not in ledger.kernels.simulated:
        return None
    beside = _Beside(search, ledger, scored.best)
    return beside.told() if beside.promise > named_log_odds() else None


@dataclass(frozen=True, eq=False)
class _Tried:
    """A row with a free function, as it is scored."""

    found: WithUnknown
    own: Ledger
    score: float
    under: Whitening
    size: float

    @property
    def elements(self) -> frozenset[str]:
        return self.found.left.elements


@dataclass(frozen=True, eq=False)
class _Promised:
    """A kind of function beside a row, as a straight line tells it."""

    kind: Kind
    evidence: float
    size: float
    effective: float


class _Beside:
    """Free functions beside the best row of laws, and beside what it holds."""

    def __init__(self, search: Search, ledger: Ledger, best: frozenset[str]) -> None:
        self._search, self._ledger, self._best = search, ledger, ledger.rows[best]
        self._quiet = search.noise.cared_about(self._best, ledger)
        self._known: dict[frozenset[str], _Tried | None] = {}
        self._ranks: dict[Fitted, list[_Promised]] = {}

    @cached_property
    def _energy(self) -> float:
        """Whitened square of what functions of unit size cause at the torque port."""
        columns = inadequacy_columns(self._search.problem, self._ledger.kernels, self._best)
        return self._quiet.square(columns)

    def _caused(self) -> Iterator[tuple[Kind, list[Array], list[Array]]]:
        """Kinds of unit size, with what they cause, as it is and whitened; those that show."""
        for made in kinds(self._search.problem, self._ledger.kernels, self._best):
            columns = self._columns(made)
            white = self._quiet(columns)
            shown = sum(float(np.sum(z**2)) for z in white)
            kind = of_unit_size(made, self._energy, shown)
            if kind is not None:
                factor = kind.unit / made.unit
                yield kind, [factor * c for c in columns], [factor * z for z in white]

    def _columns(self, kind: Kind) -> list[Array]:
        """[SI] What the functions of a kind cause, shape (c, m, n), by segment.

        Made when they are asked for: of all kinds together they would fill the memory.
        """
        problem, kernels = self._search.problem, self._ledger.kernels
        return through_loop(problem, kernels, kind.port, kind.signals, as_simulated=True)

    @property
    def promise(self) -> float:
        """[nats] Gain of a free function beside the best row, as a straight line tells it.

        Or in place of one of its laws, or of all: two of them may imitate what is none. Nothing
        beside that row is promised of a function that would be too small to matter.
        """
        row, rows = self._best, self._ledger.rows
        inner = grams(self._search.problem, row.beside_own_parts(self._quiet), row)
        alone = float(log_evidences(row, inner, self._once)[0])
        alone += self._search.log_prior(row.elements)
        asked = [row, *(rows[e] for e in self._fewer(row.elements) if e in rows)]
        pairs = zip(asked, self._ranked(asked), strict=True)
        gains = [
            found[0].evidence + self._prior(one.elements)
            for one, found in pairs
            if found and (one is not row or found[0].effective >= self._search.tolerance)
        ]
        return max(gains, default=-np.inf) - alone

    def told(self) -> Unknown | None:
        """The unknown, or None where it is not believed."""
        now = next(iter(self._beside([self._best])), None)
        if now is None:
            return None
        seen = set[_Tried]()
        while now not in seen:
            seen.add(now)
            less = [one for one in self._with_less(now) if self._is_as_likely(one, now)]
            now = max(less, key=lambda one: one.score, default=now)
            more = [one for one in self._with_more(now) if not self._is_as_likely(now, one)]
            now = max(more, key=lambda one: one.score, default=now)
        alone, beside = self._under(self._best), self._under(now.found.left)
        gain = self._with(now, self._once, beside) - self._alone(self._once, alone)
        if float(gain[0]) <= named_log_odds():
            return None
        if now.found.effective < self._search.tolerance and now.elements >= self._best.elements:
            return None  # too small to matter, unless it replaces a law
        weights = weightings(self._once.shape[1])
        odds = self._with(now, weights, beside) - self._alone(weights, alone)
        probability = float(np.mean(expit(odds)))
        if probability < NAMED:
            return None
        kind = now.found.kind
        function = FreeFunction(self._search.problem, now.under, now.found, now.size)
        return Unknown(
            kind.port, kind.against, probability, float(odds.mean()), now.elements, function
        )

    def _with_less(self, now: _Tried) -> list[_Tried]:
        """Rows that lack one element of a row, and that without any."""
        known = (self._ledger.rows.get(elements) for elements in self._fewer(now.elements))
        return self._beside([self._under_noise(row) for row in known if row is not None])

    @staticmethod
    def _fewer(elements: frozenset[str]) -> list[frozenset[str]]:
        """All but one of some elements, and none."""
        fewer = {frozenset[str](), *(elements - {name} for name in elements)} - {elements}
        return sorted(fewer, key=sorted)

    def _with_more(self, now: _Tried) -> list[_Tried]:
        """Rows with one element of the best row more, fitted from where the function ended.

        Beside a law the function was fitted to what that law left. Where it then did better alone,
        the fit of both had ended in another hollow.
        """
        problem, found = self._search.problem, []
        for name in sorted(self._best.elements - now.elements):
            known = self._ledger.rows.get(now.elements | {name})
            if known is None:
                continue
            row = self._under_noise(known)
            start = begun_as(problem, row, now.found)
            if start is not None:
                found.append(self._in_turn(row, start, now.own, now.size))
        for one in found:
            before = self._known.get(one.elements)
            if before is None or before.score < one.score:
                self._known[one.elements] = one
        return found

    @staticmethod
    def _is_as_likely(one: _Tried, other: _Tried) -> bool:
        """Whether a row with a function is no less likely than another, but for what tells."""
        return one.score > other.score - named_log_odds()

    def _under_noise(self, row: Fitted) -> Fitted:
        """A row fitted under the noise that the best one tells, as only the best rows were."""
        ledger = self._ledger
        if row.heard is ledger.noise_of(row.elements):
            return row
        return RowFits(self._search.problem, ledger.noise_of).again(ledger.whitening, row, {})

    def _alone(self, weights: Array, levels: Sequence[Ledger]) -> Array:
        """[nats] Of the best row of laws, under each weighting of the stretches.

        Its noise is the likeliest of the levels at hand: those of spectra are near the likeliest
        ones, and those beside a function may by chance fit the laws alone better.
        """
        search, row, beside = self._search, self._best, BesideInadequacy(self._search.problem)
        found = []
        for under in levels:
            extra = beside.begin(replace(under, rows={row.elements: row}))
            logs = with_inadequacy(row, beside.grams(row), weights, extra, search.tolerance)[0]
            found.append(logs + search.log_prior(row.elements))
        return max(found, key=np.mean)

    def _with(self, now: _Tried, weights: Array, levels: Sequence[Ledger]) -> Array:
        """[nats] The same of a row with its function."""
        found = [self._sized(now.found, own, weights).log_evidences for own in levels]
        return max(found, key=np.mean) + self._prior(now.elements)

    def _under(self, row: Fitted) -> list[Ledger]:
        """Noise of the levels at hand, larger in stretches in which a row leaves more."""
        noise, found = self._search.noise, []
        for own in self._levels:
            errors = noise.with_own_parts(row, own.kernels, own.levels, own.errors)
            whitening = noise.scaled(row, own.kernels, own.levels, errors)
            found.append(replace(own, whitening=whitening, errors=errors))
        return found

    @cached_property
    def _levels(self) -> list[Ledger]:
        """Levels of noise at hand: those that the laws leave, then those of each function."""
        return [self._search.noise.alone(self._best, self._ledger)]

    def _beside(self, rows: Sequence[Fitted]) -> list[_Tried]:
        """The likeliest free function beside each row; without those beside which none shows."""
        new = [row for row in rows if row.elements not in self._known]
        for row, ranked in zip(new, self._ranked(new), strict=True):
            tried = [self._tried(row, one.kind, one.size) for one in ranked[:_TRIED]]
            self._known[row.elements] = max(tried, key=lambda one: one.score, default=None)
        found = (self._known[row.elements] for row in rows)
        return [one for one in found if one is not None]

    def _ranked(self, rows: Sequence[Fitted]) -> list[list[_Promised]]:
        """Kinds beside each row as a straight line tells them, best first."""
        search, new = self._search, [row for row in rows if row not in self._ranks]
        found: dict[Fitted, list[_Promised]] = {row: [] for row in new}
        for kind, columns, white in self._caused() if new else ():
            for row, own in found.items():
                start = WithUnknown(kind, columns, row, np.zeros(kind.count))
                sized = start.sized(
                    search.problem, self._quiet, self._once, search.tolerance, white
                )
                effective = replace(start, amplitudes=sized.amplitudes).effective
                own.append(_Promised(kind, float(sized.log_evidences[0]), sized.size, effective))
        self._ranks |= {
            row: sorted(own, key=lambda one: -one.evidence) for row, own in found.items()
        }
        return [self._ranks[row] for row in rows]

    def _tried(self, row: Fitted, kind: Kind, size: float) -> _Tried:
        """Fit a function, and the noise beside it, in turn until nothing gains.

        It is first fitted loosely, under what the row leaves without it.
        """
        start = WithUnknown(kind, self._columns(kind), row, np.zeros(kind.count))
        return self._in_turn(row, start, self._search.noise.alone(row, self._ledger), size)

    def _in_turn(self, row: Fitted, start: WithUnknown, own: Ledger, size: float) -> _Tried:
        """Fit a function under some noise, and the noise beside it."""
        search, kind, best = self._search, start.kind, None
        for _ in range(_LEVELS):
            under, used = own.whitening, size
            found = fitted_with(search.problem, under, row, start, used)
            own = search.noise.alone(found.left, self._ledger)
            sized = self._sized(found, own, self._once)
            score = float(sized.log_evidences[0]) + self._prior(row.elements)
            if best is not None and score < best.score + WORTH:
                break
            best, start, size = _Tried(found, own, score, under, used), found, sized.size
        assert best is not None
        self._levels.append(best.own)
        search.log(
            f"{kind.port} over {kind.against} ({kind.count}) beside {sorted(row.elements)}: "
            f"{best.score:.1f}"
        )
        return best

    def _sized(self, found: WithUnknown, own: Ledger, weights: Array) -> Sized:
        search = self._search
        return found.sized(search.problem, own.whitening, weights, search.tolerance)

    def _prior(self, elements: frozenset[str]) -> float:
        """[nats] Of a free function of one kind beside these elements."""
        count = max(len(found) for found in self._ranks.values())
        return self._search.log_prior(elements | {_NAME}) - log(max(count, 1))

    @cached_property
    def _once(self) -> Array:
        return np.ones((1, sum(len(own) for own in self._search.problem.stretches())))
