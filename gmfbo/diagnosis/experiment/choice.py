"""Choose what to play: what separates rivals best, or shows best what was not excited."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.experiment.menu_runs import play
from gmfbo.diagnosis.experiment.reference_menu import PARTS, MenuEntry
from gmfbo.diagnosis.experiment.separation import ENOUGH, Plays, Separation, separations
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.result.predictions import said
from gmfbo.plain_words import listed, number, words

Size = Callable[[str, Plays], float]
"""Smallest size of an effect that a run shows; infinite where it shows none."""

_UNSEEN = 100.0  # times the smallest size: an effect that does not show counts as this large


@dataclass(frozen=True, eq=False)
class Choice:
    """What is played, and why.

    Attributes
    ----------
    plays : tuple of int
        Patterns of the menu, one after the other.
    motion : str
        The same in words: "a slow triangle, then a chirp".
    shown : tuple of str
        Effects for which it was chosen and that it shows; none where rivals are separated.
    separation : Separation or None
        None where it was not chosen to separate rivals.
    """

    plays: Plays
    motion: str
    shown: tuple[str, ...] = ()
    separation: Separation | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Rivals that it tells apart, or effects that it shows; none where it would be in vain."""
        if self.separation is None:
            return self.shown
        apart = self.separation.told_apart
        return tuple(n for n in self.separation.rivals if any(n in pair for pair in apart))

    @property
    def why(self) -> str:
        """What it does, as the rest of a sentence that begins with the motion."""
        if self.separation is None:
            return f"excites what was not excited so far: {', '.join(map(words, self.shown))}"
        apart = self.separation.told_apart
        if not apart:
            pair, largest = max(self.separation.log_odds.items(), key=lambda one: one[1])
            return (
                f"tells no two apart, {_pairs([pair])} most nearly: log odds of {number(largest)} "
                f"nats are expected, {number(ENOUGH)} would be enough"
            )
        together = [pair for pair in self.separation.log_odds if pair not in apart]
        if together:
            return f"tells {_pairs(apart)}; it does not tell {_pairs(together)}"
        if len(apart) > 1:
            return f"tells {listed(map(said, self.names))} apart"
        return f"tells {_pairs(apart)}"


def choose(
    case: Case,
    entries: Sequence[MenuEntry],
    rivals: Mapping[str, Fitted],
    effects: Sequence[str],
    size: Size,
) -> Choice | None:
    """Choose two patterns of a menu, to be played one after the other.

    They tell most pairs of rivals apart, and these by the widest margin. Without rivals the mean
    logarithm of the effects' smallest sizes is least, each relative to the best on the menu.

    Parameters
    ----------
    case : Case
        Twin and noise; it plays the menu now.
    entries : sequence of MenuEntry
        Patterns of the menu.
    rivals : mapping of str to Fitted
        Explanations by name; fewer than two are no rivals.
    effects : sequence of str
        What is to be shown where there are no rivals.
    size : callable (str, tuple of int) -> float
        Smallest size of an effect that a run shows.

    Returns
    -------
    Choice or None
        None where the menu is empty, or fewer than two rivals can follow it.
    """
    plays = list(combinations_with_replacement(range(len(entries)), PARTS))
    if not plays:
        return None
    if len(rivals) < 2:
        best = _most_shown(plays, effects, size)
        shown = tuple(name for name in effects if math.isfinite(size(name, best)))
        return Choice(best, _motion(entries, best), shown)
    played = {name: play(case, rival) for name, rival in rivals.items()}
    runs = {name: one for name, one in played.items() if one is not None}
    if len(runs) < 2:
        return None
    best_of = max(separations(case, runs, plays), key=lambda one: one.worth)
    return Choice(best_of.plays, _motion(entries, best_of.plays), separation=best_of)


def _most_shown(plays: Sequence[Plays], effects: Sequence[str], size: Size) -> Plays:
    badness = dict.fromkeys(plays, 0.0)
    for name in effects:
        sizes = {play: size(name, play) for play in plays}
        least = min(sizes.values())
        if math.isfinite(least):
            for play, own in sizes.items():
                badness[play] += math.log(min(own / least, _UNSEEN))
    return min(plays, key=badness.__getitem__)


def _motion(entries: Sequence[MenuEntry], plays: Plays) -> str:
    first, second = (entries[place].words for place in plays)
    return f"{first}, played twice" if first == second else f"{first}, then {second}"


def _pairs(pairs: Iterable[tuple[str, str]]) -> str:
    return "; ".join(f"{said(a)} from {said(b)}" for a, b in pairs)
