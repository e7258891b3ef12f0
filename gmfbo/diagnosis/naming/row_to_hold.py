"""Which row of the comparison a model holds, for the sets of laws that are told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gmfbo.diagnosis.comparison.claims import Claim
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted as Row
from gmfbo.diagnosis.comparison.numbers import MOST, NAMED
from gmfbo.diagnosis.comparison.row_fits import RowFits
from gmfbo.diagnosis.naming.decision import Compared


def effects_of(claim: Claim) -> list[str]:
    """Members of a set that are effects, no fixed parameters.

    Parameters
    ----------
    claim : Claim
        The set.
    """
    return [name for name in claim.members if not name.startswith("parameter:")]


def _stand_ins(claim: Claim) -> list[str]:
    """Those of a set that a model may hold for it: its effects, or where it has none, all."""
    return effects_of(claim) or list(claim.members)


def held_by(said: Sequence[Claim], elements: frozenset[str]) -> list[tuple[Claim, str]]:
    """Each claim with the most believed of its set that a model holds; "" where it holds none.

    Parameters
    ----------
    said : sequence of Claim
        What is told.
    elements : frozenset of str
        Of the model.
    """
    held: list[tuple[Claim, str]] = []
    for claim in said:
        left = elements - {name for _, name in held}
        held.append((claim, next((name for name in _stand_ins(claim) if name in left), "")))
    return held


def model_row(
    compared: Compared,
    said: Sequence[Claim],
    above: Mapping[frozenset[str], Mapping[str, float]],
) -> Row:
    """The mode of the row that a model holds.

    Parameters
    ----------
    compared : Compared
        Rows, and beliefs in them.
    said, above
        As of `row_to_hold`.
    """
    scored, ledger = compared.scored, compared.ledger
    fits = RowFits(compared.search.problem, ledger.noise_of)
    order = [scored.elements[i] for i in np.argsort(-scored.log_evidences.mean(1))]
    chosen = row_to_hold(order, said, above)
    row = ledger.rows[scored.best if chosen is None else chosen]
    return fits.to_the_end(ledger.whitening, row)


def nearest_row(compared: Compared, row: Row, port: str) -> Row | None:
    """A row with laws that come nearest to something unknown, each the most of what is left.

    Whether one of them acts is not asked: none is believed to.

    Parameters
    ----------
    compared : Compared
        Rows, and beliefs in them.
    row : Row
        With what is told.
    port : str
        Where the unknown acts.

    Returns
    -------
    Row or None
        None where no law at that port makes more than half of it.
    """
    ledger, noise = compared.ledger, compared.search.noise
    near, base = row, ledger.rows[frozenset()]

    def left_by(own: Row) -> float:
        share = noise.share(base, own, ledger)
        return 0.0 if share is None else 1.0 - share

    while (left := left_by(near)) > 0.0:
        found = [own for own in ledger.rows.values() if _adds_one(own, near, port)]
        best = min(found, key=left_by, default=near)
        if left_by(best) > (1.0 - MOST) * left:
            break
        near = best
    if near is row:
        return None
    return RowFits(compared.search.problem, ledger.noise_of).to_the_end(ledger.whitening, near)


def _adds_one(own: Row, row: Row, port: str) -> bool:
    """Whether a row has one law more than another, at some port."""
    new = own.elements - row.elements
    laws = [e.law for e in own.hypothesis.effects if e.effect in new]
    return own.elements > row.elements and len(new) == 1 and [law.port for law in laws] == [port]


def row_to_hold(
    order: Sequence[frozenset[str]],
    said: Sequence[Claim],
    above: Mapping[frozenset[str], Mapping[str, float]],
) -> frozenset[str] | None:
    """The most believed row with one of each set, and nothing else; None where none has them all.

    Which one of a set fits best depends on the others. Where no such row was fitted, what else it
    holds changes nothing in these recordings; but a limit just above them would act in larger ones.

    Parameters
    ----------
    order : sequence of frozenset of str
        Rows, the most believed first.
    said : sequence of Claim
        What is told.
    above : mapping of frozenset of str to mapping of str to float
        Probability, by row and element, that a size is above its floor.
    """
    told = {row: {name for _, name in held_by(said, row)} for row in order}
    holding = [row for row in order if "" not in told[row]]
    alone = [row for row in holding if row == told[row]]
    still = [
        row
        for row in holding
        if not any(_is_there(name, above.get(row, {})) for name in row - told[row])
    ]
    return next(iter((*alone, *still, *holding)), None)


def _is_there(name: str, shares: Mapping[str, float]) -> bool:
    """Whether an element changes a model: a law above its floor, or any freed parameter."""
    return name.startswith("parameter:") or shares.get(name, 1.0) >= NAMED
