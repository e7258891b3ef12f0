"""Whether the stated probabilities can be believed: reliability, and the Brier score."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tests.blind.score import Scored

EDGES = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 1.0001)
ALWAYS = 0.95


def claims_of(scores: Sequence[Scored]) -> list[tuple[float, bool]]:
    """Stated probability of each name in the catalogue's cases, and whether it is right."""
    return [claim for s in scores if s.kind != "outside" for claim in s.claims]


def events_of(scores: Sequence[Scored]) -> tuple[list[float], list[float], list[bool]]:
    """Forecasts, the same by always 0.95, and what was true, abstentions counted.

    A claim is a forecast that its name is right. An abstention is a forecast of 0 that a name is
    owed: it is true where an effect of more than 60 is hidden.
    """
    stated, always, true = [], [], []
    for s in scores:
        if s.outcome == "failed":
            continue
        if s.kind == "outside":
            claims = [(p, False) for p, _ in s.claims if s.has_false_name]
        else:
            claims = list(s.claims)
        for p, right in claims:
            stated.append(p)
            always.append(ALWAYS)
            true.append(right)
        if not s.named:
            stated.append(0.0)
            always.append(0.0)
            true.append(s.is_owed)
    return stated, always, true


def brier_scores(scores: Sequence[Scored]) -> str:
    """Text: mean squared error of the probabilities (Brier 1950), and of two that know less."""
    stated, always, true = (np.array(part, dtype=float) for part in events_of(scores))
    if not len(true):
        return "Brier score: nothing to count"
    rows = [
        ("stated probabilities", stated),
        ("always 0.95 for a claim", always),
        ("base rate of all events", np.full(len(true), np.mean(true))),
    ]
    lines = [f"{'Brier score, abstentions counted':<36}{'events':>8}{'score':>10}"]
    lines += [f"{title:<36}{len(true):>8}{np.mean((p - true) ** 2):>10.4f}" for title, p in rows]
    claims = claims_of(scores)
    if claims:
        p, right = np.array(claims, dtype=float).T
        lines += [
            f"{'claims only: stated':<36}{len(p):>8}{np.mean((p - right) ** 2):>10.4f}",
            f"{'claims only: always 0.95':<36}{len(p):>8}{np.mean((ALWAYS - right) ** 2):>10.4f}",
            f"{'claims only: their base rate':<36}{len(p):>8}{np.var(right):>10.4f}",
        ]
    return "\n".join(lines)


def reliability(scores: Sequence[Scored]) -> str:
    """Text: how often claims of each stated probability are right."""
    lines = [f"{'probability':<16}{'claims':>7}{'mean':>8}{'right':>8}"]
    for low, high in pairwise(EDGES):
        chosen = [(p, right) for p, right in claims_of(scores) if low <= p < high]
        if chosen:
            mean, right = np.mean([p for p, _ in chosen]), np.mean([r for _, r in chosen])
            label = f"{low:g} to {min(high, 1.0):g}"
            lines.append(f"{label:<16}{len(chosen):>7}{mean:>8.2f}{right:>8.2f}")
    return "Reliability of the stated probability\n" + "\n".join(lines)
