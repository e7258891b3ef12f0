"""What could be played against rivals: how surely it would tell them apart, and the best of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.comparison.numbers import TOLD_APART
from gmfbo.diagnosis.experiment.menu_runs import Menu, Played, whitener_of
from gmfbo.diagnosis.scoring.whitening import Whitener

Names = tuple[str, str]
Plays = tuple[int, ...]

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

    def told_apart(self, enough: float = ENOUGH) -> dict[Names, float]:
        """Pairs of rivals that it decides between, with their log odds [nats].

        Parameters
        ----------
        enough : float
            [nats] Log odds that decide.
        """
        return {pair: odds for pair, odds in self.log_odds.items() if odds >= enough}

    def worth(self, enough: float = ENOUGH) -> tuple[int, float]:
        """Sort key: number of pairs told apart, then their least margin, or the largest of all.

        Parameters
        ----------
        enough : float
            [nats] Log odds that decide.
        """
        told = self.told_apart(enough)
        return len(told), min(told.values()) if told else max(self.log_odds.values())


def separations(
    case: Case, menu: Menu, runs: Mapping[str, Played], plays: Iterable[Plays]
) -> list[Separation]:
    """Separation by each of some runs that could be played.

    Parameters
    ----------
    case : Case
        Twin and noise.
    menu : Menu
        What can be played.
    runs : mapping of str to Played
        Each rival on every entry of the menu; two at least.
    plays : iterable of tuple of int
        Entries of the menu that a run plays, one after the other.
    """
    first = next(iter(runs.values()))
    whiteners = [whitener_of(case, menu, k, first.simulated[k]) for k in range(len(menu.records))]
    return [
        Separation(
            chosen,
            {
                (a, b): min(
                    log_odds(whiteners, runs[a], runs[b], chosen),
                    log_odds(whiteners, runs[b], runs[a], chosen),
                )
                for a, b in combinations(runs, 2)
            },
        )
        for chosen in plays
    ]


def log_odds(
    whiteners: Sequence[Whitener], true: Played, other: Played, plays: Sequence[int]
) -> float:
    """Expected log odds [nats] of a rival that is true against another that is refitted to it.

    Half the squared whitened distance that is left: the mean of the log likelihood ratio of two
    Gaussian predictions under the first (Kullback and Leibler 1951, "On information and
    sufficiency").

    Parameters
    ----------
    whiteners : sequence of Whitener
        Of every entry of the menu.
    true, other : Played
        The rival taken for true, and the rival fitted to it.
    plays : sequence of int
        Entries that are played.
    """
    targets, rows = [], []
    for k in plays:
        pairs = zip(true.simulated[k].signals, other.simulated[k].signals, strict=True)
        targets.append(whiteners[k].whiten([a - b for a, b in pairs]))
        if other.columns:
            own = [np.stack(list(s)) for s in zip(*(c[k] for c in other.columns), strict=True)]
            rows.append(np.nan_to_num(whiteners[k].whiten(own)))
    left = np.concatenate(targets)
    if rows:
        matrix = np.concatenate(rows, axis=1).T
        size = np.linalg.norm(matrix, axis=0)
        matrix = matrix[:, size > 0.0] / size[size > 0.0]
        left = left - matrix @ np.linalg.lstsq(matrix, left, rcond=1e-8)[0]
    return 0.5 * float(left @ left)
