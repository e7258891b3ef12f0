"""Smallest size of each effect that recordings could show, alone and all together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.checking.result import Showable
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Ledger
from gmfbo.diagnosis.comparison.moves import Element, Response, Shown, responses, shown
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.problem import Problem
from gmfbo.diagnosis.comparison.search import Search
from gmfbo.diagnosis.comparison.whitener import Whitening
from gmfbo.diagnosis.naming.decision_told import units_of
from gmfbo.diagnosis.naming.shown_sizes import detectable_sizes, not_shown
from gmfbo.diagnosis.result.named_effect import DetectableSize, NotTestable
from gmfbo.diagnosis.screening.testable_effects import untestable
from gmfbo.physics import CATALOGUE

_CHUNK = 6  # starts simulated between two reports of progress


@dataclass(frozen=True)
class Excited:
    """Effects that recordings can show, and those that they cannot.

    Attributes
    ----------
    showable : mapping of str to Showable
        Smallest sizes by effect.
    not_testable : tuple of NotTestable
        The other effects, each with its reason.
    """

    showable: Mapping[str, Showable]
    not_testable: tuple[NotTestable, ...]


def showable_sizes(case: Case, progress: Callable[[float], None]) -> Excited:
    """Scale each effect to the size at which a diagnosis would tell it beside noise.

    Noise, errors of the logger and what parameters can make are those of a diagnosis that begins;
    of what the twin may lack no more is forgiven than what nobody cares about.

    Parameters
    ----------
    case : Case
        At nominal parameters.
    progress : callable (float)
        Called with the share done.
    """
    reasons = untestable(
        case.twin.file,
        case.setting.excitation,
        has_inertia=case.setting.inertia is not None,
        is_open=case.simulations.tracking is not None,
    )
    comparison = comparison_of(case, [name for name in CATALOGUE if name not in reasons])
    search = comparison.search
    ledger = search.opened(comparison.first)
    effects = [e for e in search.elements if e.candidate is not None]
    seen = _Seen.of(search, ledger, _tried(search.problem, ledger, effects, progress))
    reasons |= not_shown(effects, seen.found, seen.together(), (), case.setting.excitation)

    def sizes(told: Sequence[Shown]) -> dict[str, DetectableSize]:
        return detectable_sizes(told, case.setting.excitation, reasons, units_of(case))

    names = [record.name for record in case.simulations.records]
    alone = {name: sizes(seen.alone(k)) for k, name in enumerate(names)}
    showable = {}
    for name, size in sizes(seen.together()).items():
        by_one = {k: own[name].size if name in own else math.inf for k, own in alone.items()}
        floor = CATALOGUE[name].floor(case.setting.excitation)
        showable[name] = Showable(size.parameter, size.unit, size.size, by_one, floor)
    return Excited(
        showable,
        tuple(NotTestable(name, reasons[name]) for name in CATALOGUE if name in reasons),
    )


def _tried(
    problem: Problem,
    ledger: Ledger,
    effects: Sequence[Element],
    progress: Callable[[float], None],
) -> list[Response]:
    base, found = ledger.rows[frozenset()], list[Response]()
    for first in range(0, len(effects), _CHUNK):
        progress(first / len(effects))
        found += responses(problem, base, effects[first : first + _CHUNK])
    return found


@dataclass(frozen=True, eq=False)
class _Seen:
    """Changes of the signals by effects, and the noise beside which they are seen.

    Attributes
    ----------
    problem : Problem
        With the segments.
    base : Fitted
        The refitted twin.
    whitening : Whitening
        By noise.
    found : list of Response
        Of the effects.
    """

    problem: Problem
    base: Fitted
    whitening: Whitening
    found: list[Response]

    @classmethod
    def of(cls, search: Search, ledger: Ledger, found: list[Response]) -> _Seen:
        """State what is seen beside a ledger's noise."""
        base = ledger.rows[frozenset()]
        return cls(search.problem, base, search.noise.cared_about(base, ledger), found)

    def together(self) -> list[Shown]:
        """How well all recordings show each effect."""
        return shown(self.whitening, self.base, self.found)

    def alone(self, record: int) -> list[Shown]:
        """How well one recording shows each effect; nothing where none of it is compared."""
        kept = [i for i, s in enumerate(self.problem.segments) if s.record == record]
        if not kept:
            return []
        base = replace(self.base, columns=[self.base.columns[i] for i in kept])
        parts = tuple(self.whitening.parts[i] for i in kept)
        found = [replace(r, columns=[r.columns[i] for i in kept], _white=[]) for r in self.found]
        return shown(Whitening(parts, self.whitening.spreads), base, found)
