"""Decide which effects are missing: hypotheses compared by one score, and what follows from it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import count

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.claims import Claim, Shares, claims_of, shares_above_floor
from gmfbo.diagnosis.comparison.evidence import grams
from gmfbo.diagnosis.comparison.fitted_hypothesis import Fitted as Row
from gmfbo.diagnosis.comparison.moves import Shown, shown
from gmfbo.diagnosis.comparison.numbers import (
    DOUBTED,
    NAMED,
    named_log_odds,
)
from gmfbo.diagnosis.comparison.opened_comparison import comparison_of
from gmfbo.diagnosis.comparison.unknown.beside import Unknown, unknown_beside
from gmfbo.diagnosis.fitting.fit import Fitted, stacked
from gmfbo.diagnosis.fitting.hypothesis import Candidate
from gmfbo.diagnosis.fitting.misfit import Misfit
from gmfbo.diagnosis.naming.decision import Compared, Decision, Evidence, Round, WrongValue
from gmfbo.diagnosis.naming.row_to_hold import effects_of, held_by, model_row, nearest_row
from gmfbo.diagnosis.naming.shown_sizes import not_shown
from gmfbo.diagnosis.naming.stretch_evidence import acting_of, gains_of, per_recording, seen_once
from gmfbo.diagnosis.naming.worth import as_told
from gmfbo.diagnosis.result.certainty import LEAST_FOR_A_FACT
from gmfbo.diagnosis.result.named_effect import RivalShare
from gmfbo.physics import CATALOGUE
from gmfbo.plain_words import listed, words

Array = NDArray[np.float64]

_COMPARED, _TO_GO, _EACH = 0.85, 0.65, 0.85  # shares of a diagnosis, and of what is left by a line


def decide(
    case: Case,
    testable: Collection[str],
    passing: Sequence[Candidate],
    progress: Callable[[str, float], None],
    *,
    silent: Collection[str] = (),
    held: Collection[str] = (),
) -> Decision:
    """Compare the laws of the library and the twin's fixed parameters by one score.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    testable : collection of str
        Effects that the recordings can show.
    passing : sequence of Candidate
        Disturbances that passed once, as a search found them.
    progress : callable (str, float)
        Told the stage and the share that is done.
    silent : collection of str
        Effects that only a reversal makes sure, which the recordings lack.
    held : collection of str
        Parameters of the twin that nobody may doubt.
    """
    log = _moving_on(progress)
    comparison = comparison_of(case, {*testable, *silent}, passing, held=held, log=log)
    ledger, scored = comparison.run()
    compared = Compared(comparison.search, ledger, scored)
    unknown = unknown_beside(compared.search, ledger, scored)
    believed, above = _believed(compared)
    said, notes = _beside(believed, unknown)
    base = ledger.rows[frozenset()]
    seen = shown(ledger.whitening, base, ledger.responses)
    row = model_row(compared, said, above)
    held_by_row = [one for one in held_by(said, row.elements) if one[1]]
    model = measured(case.misfit, row)
    most = LEAST_FOR_A_FACT if unknown is not None else 1.0
    rounds = [
        _round(case, compared, row, model, *one, min(most, _most_of(one[0], silent)))
        for one in held_by_row
        if effects_of(one[0])
    ]
    return Decision(
        rounds=tuple(sorted(rounds, key=lambda r: -r.gain)),
        freed=_freed(compared, held_by_row, most),
        model=model,
        row=row,
        base=base,
        threshold=named_log_odds(),
        shown=tuple(seen),
        untestable=_untestable(case, compared, seen, said),
        share=compared.search.noise.share(base, row, ledger),
        compared=compared,
        unknown=unknown,
        unsettled=_unsettled(compared, believed, unknown),
        nearest=None if unknown is None else nearest_row(compared, row, unknown.port),
        notes=(*notes, *_notes_of(rounds, silent), *_counts_told(compared)),
    )


def _untestable(
    case: Case, compared: Compared, seen: Sequence[Shown], said: Sequence[Claim]
) -> dict[str, str]:
    """Effects about which these recordings tell nothing, and why; never one that is said."""
    names = {name for one in said for name in one.members}
    elements, found = compared.search.elements, compared.ledger.responses
    return not_shown(elements, found, seen, names, case.setting.excitation)


def _unsettled(
    compared: Compared, believed: Sequence[Claim], unknown: Unknown | None
) -> frozenset[str]:
    """Effects of which nobody can say that they would have been named if they were there."""
    names = {name for claim in believed for name in claim.members}
    laws = [e.candidate.law for e in compared.search.elements if e.candidate is not None]
    if unknown is not None:
        names |= {law.name for law in laws if law.port == unknown.port}
    return frozenset(names)


def _freed(
    compared: Compared,
    held: Sequence[tuple[Claim, str]],
    most: float,
) -> dict[str, WrongValue]:
    """Sets of fixed parameters alone, by the one that a model holds."""
    found = {}
    for claim, name in held:
        if not effects_of(claim):
            own = (name, *(n for n in claim.members if n != name))
            belief, gain = min(claim.probability, most), _log_odds(compared, claim)
            wrong = WrongValue(own, belief, gain, as_told(belief, gain, most), most)
            found[name.removeprefix("parameter:")] = wrong
    return found


def _moving_on(progress: Callable[[str, float], None]) -> Callable[[str], None]:
    """Move progress on with each line that a search tells; how many come is not known before."""
    shares = (_TO_GO * _EACH**k for k in count())

    def told(line: str) -> None:
        progress("comparing explanations", _COMPARED - next(shares))

    told("begun")
    return told


def _believed(
    compared: Compared,
) -> tuple[list[Claim], dict[frozenset[str], Mapping[str, float]]]:
    """Claims that are believed enough to be told; by row, how likely elements are above floors."""
    shares = _shares(compared)
    claims = [c for c in claims_of(compared.scored, shares) if c.probability >= NAMED]
    return claims, {elements: own.above for elements, own in shares.items()}


def _most_of(claim: Claim, silent: Collection[str]) -> float:
    """Most that is told of a set; less where only a reversal would make sure of one of it."""
    return DOUBTED if set(claim.members) & set(silent) else 1.0


def _beside(said: Sequence[Claim], unknown: Unknown | None) -> tuple[list[Claim], list[str]]:
    """Claims that add something beside what is unknown, and why the others are not told."""
    if unknown is None:
        return list(said), []
    kept = [claim for claim in said if unknown.beside & _holding(claim)]
    place = f"a function of the {words(unknown.against)} at the {words(unknown.port)} port"
    notes = [
        f"{' or '.join(map(words, claim.members))} is not named: {place}, which is no law that is "
        "known here, explains more, and nothing is gained by both"
        for claim in said
        if claim not in kept
    ]
    return kept, notes


def _holding(claim: Claim) -> set[str]:
    """Members of a set, and the laws that hold one of them as their limit."""
    members = set(claim.members)
    return members | {n for n, law in CATALOGUE.items() if members & set(law.contains)}


def measured(misfit: Misfit, row: Row) -> Fitted:
    """State a row of the comparison as a fit whitened by a budget of noise.

    Parameters
    ----------
    misfit : Misfit
        That budget.
    row : Row
        A fitted hypothesis.
    """
    hypothesis, x = row.hypothesis, row.x
    quiet = misfit.simulations.run([hypothesis.point(x)])[0]
    runs = quiet if row.own.any() else row.runs  # own parts hold in these recordings alone
    columns = [
        list(c) for c in misfit.sensitivities(hypothesis, x, quiet, range(x.size), parallel=True)
    ]
    return Fitted(
        hypothesis,
        x,
        runs,
        misfit.residual(runs),
        tuple(np.nan_to_num(block) for block in stacked(misfit, columns)),
        columns,
        row.converged,
    )


def _shares(compared: Compared) -> dict[frozenset[str], Shares]:
    """By row, how likely its elements are there; of rows that matter."""
    ledger, scored = compared.ledger, compared.scored
    shares = dict.fromkeys(scored.elements, Shares())
    for elements, belief in zip(scored.elements, scored.beliefs, strict=True):
        if belief > (1.0 - NAMED) / len(scored.elements):
            row = ledger.rows[elements]
            whitening = row.beside_own_parts(ledger.whitening)
            shares[elements] = shares_above_floor(
                row, grams(compared.search.problem, whitening, row)
            )
    return shares


def _round(
    case: Case,
    compared: Compared,
    row: Row,
    model: Fitted,
    claim: Claim,
    winner: str,
    most: float,
) -> Round:
    """A claim as it is told, with no more belief than is left where laws are of the wrong form."""
    rows = compared.ledger.rows
    without = rows.get(row.elements - {winner}, rows[frozenset()])
    beliefs = dict(zip(claim.members, claim.beliefs, strict=True))
    others = [name for name in claim.members if name != winner]
    rivals = []
    for name in others:
        there = rows.get((row.elements - {winner}) | {name})
        if there is None:
            there = next(r for e, r in rows.items() if name in e)
        rivals.append(Evidence(name, measured(case.misfit, there)))
    gains = gains_of(compared, row, without)
    names = [record.name for record in case.simulations.records]
    once = seen_once(names, compared, gains, acting_of(compared, row, winner, gains))
    most = min(most, DOUBTED) if once else most
    belief, gain = min(claim.probability, most), _log_odds(compared, claim)
    probability = as_told(belief, gain, most)
    shares = [
        RivalShare(name, probability / claim.probability * beliefs[name])
        for name in (winner, *others)
    ]
    return Round(
        Evidence(winner, model),
        tuple(rivals),
        belief,
        probability,
        tuple(shares) if others else (),
        gain,
        per_recording(names, compared, gains),
        once,
        most,
    )


def _log_odds(compared: Compared, claim: Claim) -> float:
    """[nats] Of the best hypothesis with one of a set, against the best one with none of it.

    A law that holds one of the set as its limit has it, too.
    """
    scored, holding = compared.scored, _holding(claim)
    logs = scored.log_evidences.mean(1)
    holds = np.array([bool(elements & holding) for elements in scored.elements])
    return float(logs[holds].max() - logs[~holds].max())


def _counts_told(compared: Compared) -> list[str]:
    encoder = compared.search.problem.encoder
    if encoder is None:
        return []
    return [
        f"laws were compared without encoder counts in the twin ({', '.join(encoder.values)} set "
        "finer), since two runs of an axis round otherwise; augmented.fmu has them as before"
    ]


def _notes_of(rounds: Sequence[Round], silent: Collection[str]) -> list[str]:
    once = [
        f"{words(r.winner.name)} shows in one stretch only, {r.once}: seen once"
        for r in rounds
        if r.once
    ]
    unsure = [words(name) for r in rounds for name in r.names if name in silent]
    if not unsure:
        return once
    return [*once, f"no recording reverses: one that does would make sure of {listed(unsure)}"]
