"""What could be played against rivals: how surely it would tell them apart, and the best of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.numbers import TOLD_APART
from gmfbo.diagnosis.experiment.menu_runs import Played, whitener_of
from gmfbo.diagnosis.scoring.whitening import Whitener

Names = tuple[str, str]
Plays = tuple[int, ...]
Difference = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Whitened: a true rival minus another, and the other's columns by parameter."""

ENOUGH = 0.5 * TOLD_APART
"""[nats] Log odds from which two rivals are told apart."""


@dataclass(frozen=True)
class Separation:
    """What a run tells of rivals.

    Attributes
    ----------
    plays : tuple of int
        Entries of the menu that it plays, one after the other.
    log_odds : mapping of (str, str) to float
        [nats] Of two rivals: expected log odds of the one that is true against the other, refitted
        to it; the smaller of the two ways, since either may be true.
    """

    plays: Plays
    log_odds: Mapping[Names, float]

    @property
    def rivals(self) -> tuple[str, ...]:
        """Names of those that could be played, each once."""
        return tuple(dict.fromkeys(name for pair in self.log_odds for name in pair))

    @property
    def told_apart(self) -> dict[Names, float]:
        """Pairs of rivals that it decides between, with their log odds [nats]."""
        return {pair: odds for pair, odds in self.log_odds.items() if odds >= ENOUGH}

    @property
    def worth(self) -> tuple[int, float]:
        """Sort key: number of pairs told apart, then their least margin, or the largest of all."""
        told = self.told_apart
        return len(told), min(told.values()) if told else max(self.log_odds.values())


def separations(case: Case, runs: Mapping[str, Played], plays: Iterable[Plays]) -> list[Separation]:
    """Separation by each of some runs that could be played.

    Parameters
    ----------
    case : Case
        Twin and noise; it plays the menu now.
    runs : mapping of str to Played
        Each rival on every entry of the menu; two at least.
    plays : iterable of tuple of int
        Entries of the menu that a run plays, one after the other.
    """
    first = next(iter(runs.values())).simulated
    whiteners = [whitener_of(case, k, run) for k, run in enumerate(first)]
    ways = {(a, b): differences(whiteners, runs[a], runs[b]) for a, b in permutations(runs, 2)}
    return [
        Separation(
            chosen,
            {
                (a, b): min(log_odds([ways[way][k] for k in chosen]) for way in ((a, b), (b, a)))
                for a, b in combinations(runs, 2)
            },
        )
        for chosen in plays
    ]


def differences(whiteners: Sequence[Whitener], true: Played, other: Played) -> list[Difference]:
    """Whitened differences of two rivals on every entry of the menu."""
    found = []
    for k, whitener in enumerate(whiteners):
        pairs = zip(true.simulated[k].signals, other.simulated[k].signals, strict=True)
        target = whitener.whiten([a - b for a, b in pairs])
        own = [np.stack(list(s)) for s in zip(*(c[k] for c in other.columns), strict=True)]
        rows = np.nan_to_num(whitener.whiten(own)) if own else np.zeros((0, target.size))
        found.append((target, rows))
    return found


def log_odds(played: Sequence[Difference]) -> float:
    """Expected log odds [nats] of a rival that is true against another that is refitted to it.

    Half the squared whitened distance that is left: the mean of the log likelihood ratio of two
    Gaussian predictions under the first (Kullback and Leibler 1951, "On information and
    sufficiency").

    Parameters
    ----------
    played : sequence of Difference
        On what is played, one after the other.
    """
    left = np.concatenate([target for target, _ in played])
    matrix = np.concatenate([rows for _, rows in played], axis=1).T
    size = np.linalg.norm(matrix, axis=0)
    matrix = matrix[:, size > 0.0] / size[size > 0.0]
    if matrix.size:
        left = left - matrix @ np.linalg.lstsq(matrix, left, rcond=1e-8)[0]
    return 0.5 * float(left @ left)
