"""Which hypotheses a search fits next: more elements, and others in the place of one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted
from gmfbo.diagnosis.comparison.ledger import Ledger, Scored
from gmfbo.diagnosis.comparison.moves import Move, Response, ranked
from gmfbo.diagnosis.comparison.numbers import (
    LEAST_GAIN,
    MOST,
    NAMED,
    PRIOR_OF_COUNT,
    named_log_odds,
)
from gmfbo.diagnosis.comparison.row_fits import begun_as_larger, chi, limit_of
from gmfbo.physics import CATALOGUE

LATER_FITS = 3
"""Moves from a row that are fitted, those that gain most."""

Plans = list[tuple[Fitted, list[Move]]]


def plans_of(
    ledger: Ledger,
    scored: Scored,
    found: Sequence[Response],
    ahead: Collection[frozenset[str]],
    log: Callable[[str], None],
) -> Plans:
    """Moves from rows ahead: one element more; of the best one, one in another's place too.

    Parameters
    ----------
    ledger : Ledger
        With the best row, and those that lack one of its elements.
    scored : Scored
        Beliefs in its rows.
    found : sequence of Response
        Of all elements.
    ahead : collection of frozenset of str
        Rows from which nothing was tried yet.
    log : callable (str)
        Told what the moves would gain.
    """
    best = ledger.rows[scored.best]
    limits = {n for e in best.elements if e in CATALOGUE for n in CATALOGUE[e].contains}
    origins = [ledger.rows[e] for e in ahead if len(e) < len(PRIOR_OF_COUNT) - 1]
    if best.elements in ahead:
        origins += [row for row in _fewer(ledger, best) if row.elements not in ahead]
    plans = []
    for about in origins:
        moves = ranked(ledger.whitening, about, found)
        log(
            f"beside {sorted(about.elements)}: "
            + ", ".join(f"{m.element.name} {m.gain:.1f}" for m in moves[:6])
        )
        fitting = [m for m in moves if not _one_holds_the_other(m.element.name, about.elements)]
        chosen: list[Move] = []
        if about.elements or about is best:  # from the bare twin all first fits began
            chosen += [m for m in fitting if m.gain > LEAST_GAIN][:LATER_FITS]
            # A law that was found is tried as its limit as well.
            chosen += [m for m in fitting if m.element.name in limits and m not in chosen]
        if about.elements < best.elements:
            chosen += [m for m in _stand_ins(ledger, about, best, fitting) if m not in chosen]
        chosen = [m for m in chosen if about.elements | {m.element.name} not in ledger.rows]
        if about.elements not in ahead:
            chosen = [_as_fitted_alone(ledger, m) for m in chosen]
        if chosen:
            plans.append((about, chosen))
    return plans + (_larger(ledger, best, found) if best.elements in ahead else [])


def _fewer(ledger: Ledger, best: Fitted) -> list[Fitted]:
    """Rows that lack one element of the best one."""
    rows = (ledger.rows.get(best.elements - {name}) for name in best.elements)
    return [row for row in rows if row is not None]


def _stand_ins(ledger: Ledger, about: Fitted, best: Fitted, moves: Sequence[Move]) -> list[Move]:
    """Moves that may be as good as the element that the best row has beside another row.

    Else a law would be believed for want of others that explain the same and were not looked at. By
    a straight line they gain about as much as it does, or as its simplest limit, and most of what
    its fit gains.
    """
    (name,) = best.elements - about.elements
    gained = 0.5 * (chi(about, ledger.whitening) - chi(best, ledger.whitening))
    family = {name, *(CATALOGUE[name].contains if name in CATALOGUE else ())}
    own = min((move.gain for move in moves if move.element.name in family), default=0.0)
    as_much = min(NAMED * own, own - named_log_odds())
    least = max(as_much, MOST * gained, LEAST_GAIN)
    return [
        move
        for move in moves
        if move.gain > least and not _one_holds_the_other(move.element.name, frozenset({name}))
    ]


def _larger(ledger: Ledger, best: Fitted, found: Sequence[Response]) -> Plans:
    """Laws in the place of a limit of theirs, where they gain beside it, and limits of laws.

    Those that were fitted under other levels, and now leave more than their limit, count as
    not fitted.
    """
    left, plans = chi(best, ledger.whitening), []
    moves = [m for m in ranked(ledger.whitening, best, found) if m.gain > LEAST_GAIN]
    for about in _fewer(ledger, best):
        chosen = []
        for move in moves:
            row = ledger.rows.get(about.elements | {move.element.name})
            stale = row is None or chi(row, ledger.whitening) > left
            if stale and limit_of(move.element, about, {best.elements: best}) is best:
                chosen.append(move)
        if chosen:
            plans.append((about, chosen[:LATER_FITS]))
    return plans + begun_as_larger(ledger, best)


def _as_fitted_alone(ledger: Ledger, move: Move) -> Move:
    """The move from where its effect alone fits best, where that is known."""
    row = ledger.rows.get(frozenset({move.element.name}))
    if row is None or not row.hypothesis.effects:
        return move
    return replace(move, element=replace(move.element, candidate=row.hypothesis.effects[0]))


def _one_holds_the_other(name: str, elements: frozenset[str]) -> bool:
    """Whether an element is a limit of one in a row, or holds one."""
    own = CATALOGUE[name].contains if name in CATALOGUE else ()
    return any(
        other in own or (other in CATALOGUE and name in CATALOGUE[other].contains)
        for other in elements
    )
