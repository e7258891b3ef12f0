"""Simulate a proposal on draws of what is believed about the twin, before the axis runs it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from gmfbo.sources.plants.source import Source
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.initial_design import Stream, stream
from gmfbo.tuning.study.playing import play

DRAWS = 20
"""Twins on which a proposal is simulated."""

MOST_LEAVING = 0.05
"""Share of them that may leave the safety envelope: one of twenty."""

HALVINGS = 5
"""Halvings of the way to safe gains that are tried in place of a withheld proposal."""


@runtime_checkable
class BelievedSource(Protocol):
    """A twin that knows how uncertain it is."""

    def believed(self, rng: np.random.Generator) -> Source:
        """The twin at values drawn from what is believed about them."""
        ...


@dataclass(frozen=True, eq=False)
class Withheld:
    """Gains that are not proposed, and those that are in their place.

    Attributes
    ----------
    gains : mapping of str to float
        Gains to be run instead.
    leaving : int
        Draws that left the envelope at the withheld gains.
    """

    gains: Mapping[str, float]
    leaving: int

    @property
    def note(self) -> str:
        """Note for the user."""
        return (
            f"the gains first proposed were withheld: {self.leaving} of {DRAWS} believed twins "
            "left the envelope there"
        )


@dataclass(frozen=True, eq=False)
class BelievedTwins:
    """Draws of a twin for one proposal.

    Attributes
    ----------
    source : Source
        The present twin.
    history : History
        With the safety envelope, and the real runs that stayed inside it.
    """

    source: Source
    history: History

    def withheld(self, gains: Mapping[str, float], number: int) -> Withheld | None:
        """Check a proposal; None where at most one of twenty draws leaves the envelope.

        In its place come gains on the way to the nearest safe ones. Without safe gains, or where
        the whole way leaves the envelope, those with the fewest exits are taken.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name.
        number : int
            Of the trial; the draws follow from it and the seed.
        """
        history, safe = self.history, self._safe_points()
        twins = [self._drawn(number, draw) for draw in range(DRAWS)]
        leaving = self._leaving(twins, gains)
        if leaving <= MOST_LEAVING * DRAWS:
            return None
        tried = [(leaving, gains)]
        if len(safe):
            point = history.unit_point(gains)
            near = safe[int(np.argmin(((safe - point) ** 2).sum(axis=1)))]
            for halving in range(1, HALVINGS + 1):
                other = history.gains_at(near + (point - near) * 0.5**halving)
                tried.append((self._leaving(twins, other), other))
                if tried[-1][0] <= MOST_LEAVING * DRAWS:
                    break
        fewest = min(count for count, _ in tried)
        chosen = next(other for count, other in tried if count == fewest)
        return Withheld(chosen, leaving)

    def _safe_points(self) -> np.ndarray:
        history = self.history
        real = [history.unit_point(t.gains) for t in history.of("IS1") if t.status == "ok"]
        return np.vstack([history.caution.starts, *real])

    def _drawn(self, number: int, draw: int) -> Source:
        from gmfbo.sources.twin.twin import FmuTwin
        from gmfbo.sources.twin.twin_at import TwinAt
        from gmfbo.sources.twin.uncertain import uncertain_of

        rng = stream(self.history.study.seed, Stream.BELIEVED_TWIN, number, draw)
        if isinstance(self.source, BelievedSource):
            return self.source.believed(rng)
        if not isinstance(self.source, FmuTwin):
            return self.source
        values = {
            one.name: float(rng.uniform(one.low, one.high)) for one in uncertain_of(self.source)
        }
        return TwinAt(self.source, values)

    def _leaving(self, twins: list[Source], gains: Mapping[str, float]) -> int:
        """Draws that leave the envelope, as far as the twin computes the signals."""
        history = self.history
        runs = (play(twin, gains, history.experiment) for twin in twins)
        exits = (history.envelope.first_exit(run, all_signals=False) for run in runs)
        return sum(left is not None for left in exits)
