"""Decisions without names that recordings which had no part in the fit speak against."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.naming.decided_by_score import measured
from gmfbo.diagnosis.naming.decision import Decision, Evidence, Round
from gmfbo.diagnosis.validating.explained_share import Squares
from gmfbo.diagnosis.validating.validation import row_without


def met_worse_with(names: Collection[str], squares: Squares) -> str | None:
    """The effect with which held-out recordings are met worst, if worse than without, for sure.

    Parameters
    ----------
    names : collection of str
        Effects that are told.
    squares : Squares
        What the held-out stretches leave with all of them, and without each.
    """
    shares = {name: squares.share(name) for name in names}
    worse = {n: share.value for n, share in shares.items() if share is not None and share.high < 0}
    return min(worse, key=lambda name: worse[name], default=None)


def without_name(case: Case, decision: Decision, name: str) -> Decision:
    """Withdraw one effect; all else is fitted without it, and goes too where nothing fits.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        With several names.
    name : str
        The effect.
    """
    compared = decision.compared
    row = row_without(decision, name)
    if row is None:
        return without_names(case, decision, contradicted=True)
    model, fitted = measured(case.misfit, row), compared.ledger.rows

    def beside(found: Round) -> Round:
        others = row.elements - {found.winner.name}
        rows = [(r, fitted.get(others | {r.name})) for r in found.rivals]
        rivals = [
            r if own is None else Evidence(r.name, measured(case.misfit, own)) for r, own in rows
        ]
        return replace(found, winner=Evidence(found.winner.name, model), rivals=tuple(rivals))

    return replace(
        decision,
        rounds=tuple(beside(found) for found in decision.rounds if found.winner.name != name),
        row=row,
        model=model,
        share=compared.search.noise.share(decision.base, row, compared.ledger),
    )


def without_names(case: Case, decision: Decision, *, contradicted: bool) -> Decision:
    """Withdraw all effects and freed parameters.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    decision : Decision
        With its names.
    contradicted : bool
        Whether held-out recordings contradict them, and are not just met no better.
    """
    return replace(
        decision,
        rounds=(),
        freed={},
        row=decision.base,
        model=case.base,
        is_withdrawn=contradicted,
    )
