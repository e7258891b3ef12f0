"""How far a name can be trusted: the decision repeated on what each rival would have recorded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.fitting.linear_left_out import solve_weakly_bound
from gmfbo.diagnosis.fitting.misfit import Blocks
from gmfbo.diagnosis.naming.decision import Evidence, Round
from gmfbo.physics import CATALOGUE

DRAWS = 200
"""Repetitions for each hypothesis."""

_PRIOR_NULL, _PRIOR_OUTSIDE = 0.3, 0.15
_MOST_TRUSTED = 0.95  # unless there are enough draws to say more


def probability(base: Fitted, found: Round, dispersion: float, rng: np.random.Generator) -> float:
    """Probability that the named effect, or one it cannot be told from, is at work.

    Each hypothesis is replayed: its fitted change of the outputs plus noise is decided on as the
    recordings were, linearly about the twin without it. Bayes' rule with stated priors (nothing
    0.3, outside the library 0.15, the effects the rest in equal parts) gives the probability,
    with (k + 1) / (n + 2) for each frequency (Laplace 1812).

    Parameters
    ----------
    base : Fitted
        The twin before the effect was added.
    found : Round
        The winner and what competed with it.
    dispersion : float
        chi2 per degree of freedom that the best model left by the budget alone.
    rng : numpy Generator
        Source of the noise.
    """
    changes = {e.name: _change(base, e) for e in found.fitted if not _is_winner_again(e, found)}
    accepted = {found.winner.name, *(rival.name for rival in found.rivals)}
    shares = {
        name: _share_named(base, changes, change, accepted, found, rng)
        for name, change in changes.items()
    }
    nothing = tuple(np.zeros(r.size) for r in base.residual)
    null = _share_named(base, changes, nothing, accepted, found, rng)
    outside = _share_outside(base, found, dispersion)
    each = (1.0 - _PRIOR_NULL - _PRIOR_OUTSIDE) / len(changes)
    right = each * sum(shares[name] for name in accepted)
    wrong = each * sum(share for name, share in shares.items() if name not in accepted)
    total = right + wrong + _PRIOR_NULL * null + _PRIOR_OUTSIDE * outside
    return float(min(right / total, _MOST_TRUSTED))


def _is_winner_again(evidence: Evidence, found: Round) -> bool:
    """A law that contains the winner and explains no more is the winner by another name."""
    if any(evidence.name == rival.name for rival in found.rivals):
        return False
    contains = found.winner.name in evidence.effect.law.contains
    return contains and evidence.gain < found.winner.gain + found.needed


def _change(base: Fitted, evidence: Evidence) -> Blocks:
    return tuple(a - b for a, b in zip(base.residual, evidence.fitted.residual, strict=True))


def _share_outside(base: Fitted, found: Round, dispersion: float) -> float:
    """How often a law outside the library would be explained as well as the recordings were.

    What an effect can make of an unknown law is taken as evenly spread between nothing and all.
    """
    noise = sum(r.size for r in base.residual) / dispersion
    missing = max(base.chi2 - noise, 1.0)
    left = max(found.winner.chi2 - noise, 0.0)
    return float(np.clip(left / missing, 1.0 / (DRAWS + 2), 1.0))


def _share_named(
    base: Fitted,
    changes: Mapping[str, Blocks],
    truth: Blocks,
    accepted: set[str],
    found: Round,
    rng: np.random.Generator,
) -> float:
    """How often the decision names one of the accepted effects under a truth."""
    residuals = tuple(block[:, None] + rng.standard_normal((block.size, DRAWS)) for block in truth)
    names = list(changes)
    reference = _after(base.sensitivity, residuals, base.prior)
    gains = []
    for name in names:
        together = tuple(
            np.concatenate([own, change[None]])
            for own, change in zip(base.sensitivity, changes[name], strict=True)
        )
        prior = np.append(base.prior, 1e-2)
        gains.append(reference - _after(together, residuals, prior))
    table = np.array(gains)
    hits = [_is_named(names, table[:, i], accepted, found) for i in range(DRAWS)]
    return (sum(hits) + 1) / (DRAWS + 2)


def _is_named(
    names: Sequence[str], gains: NDArray[np.float64], accepted: set[str], found: Round
) -> bool:
    """Whether the best, or its simplest limit that gains as much, is one of the accepted."""
    best = int(np.argmax(gains))
    limits = CATALOGUE[names[best]].contains
    near = [i for i, n in enumerate(names) if n in limits and gains[i] > gains[best] - found.margin]
    chosen = max(near, key=lambda i: float(gains[i]), default=best)
    return names[chosen] in accepted and bool(gains[chosen] > found.needed)


def _after(
    columns: Sequence[NDArray[np.float64]],
    residuals: Sequence[NDArray[np.float64]],
    prior: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Change of the square by a fit, of each draw."""
    matrix = sum(a @ a.T for a in columns)
    vector = sum(a @ r for a, r in zip(columns, residuals, strict=True))
    change = solve_weakly_bound(np.asarray(matrix), np.asarray(vector), prior)
    left: NDArray[np.float64] = np.einsum(
        "ij,ik,kj->j", change, np.asarray(matrix), change
    ) - 2.0 * np.einsum("ij,ij->j", change, np.asarray(vector))
    return left
