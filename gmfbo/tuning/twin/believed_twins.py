"""Simulate a proposal on draws of what is believed about the twin, before the axis runs it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.store.trial import Trial
from gmfbo.sources.plants.source import Source
from gmfbo.space import SAME_POINT
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.state import TuningState
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
class Doubted:
    """A proposal at which too many believed twins leave the envelope, and what is asked.

    Attributes
    ----------
    gains : mapping of str to float
        Gains to be run; the proposed ones where nothing safer is known.
    leaving : int
        Draws that left the envelope at the proposed gains.
    withheld : bool
        Whether other gains than the proposed ones are to be run.
    note : str
        Note for the user.
    """

    gains: Mapping[str, float]
    leaving: int
    withheld: bool
    note: str


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

    def doubt(self, gains: Mapping[str, float], state: TuningState, number: int) -> Doubted | None:
        """Check a proposal; None where at most one of twenty draws leaves the envelope.

        Gains of a real run that stayed inside are known to be safe, whatever the twins say. In
        place of others come gains on the way to the nearest safe ones. Where the whole way leaves
        the envelope, the nearest real run that stayed inside is repeated. Without one, the gains
        with the fewest exits are taken; those proposed, where nothing on the way has fewer.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name.
        state : TuningState
            With the gains that are held in this proposal.
        number : int
            Of the trial; the draws follow from it and the seed.
        """
        point = self.history.unit_point(gains)
        inside = self._inside(state)
        if any(_same(point, self.history.unit_point(one.gains)) for one in inside):
            return None
        twins = self._drawn(number)
        leaving = self._leaving(twins, gains)
        if leaving <= MOST_LEAVING * DRAWS:
            return None
        way = self._way(point, inside, state)
        counts = []
        for step in way:
            counts.append(self._leaving(twins, step))
            if counts[-1] <= MOST_LEAVING * DRAWS:
                return Doubted(step, leaving, True, _withheld(leaving))
        if inside:
            smallest = (way[-1], counts[-1]) if way else (gains, leaving)
            return self._beside_safe(point, inside, leaving, smallest)
        fewest = min(counts, default=leaving)
        if fewest < leaving:
            told = (
                f"{_withheld(leaving)}; {fewest} of {DRAWS} leave it at these, the fewest found, "
                "and no real run has stayed inside yet"
            )
            return Doubted(way[counts.index(fewest)], leaving, True, told)
        why = "and no fewer nearer to the start" if way else "and no gains are known to be safe"
        return Doubted(gains, leaving, False, f"{_leaves(leaving)}, {why}")

    def leaving_note(self, gains: Mapping[str, float], number: int) -> str:
        """How many draws leave the envelope, for gains that are asked for whatever they do.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name.
        number : int
            Of the trial.

        Returns
        -------
        str
            Empty where at most one of twenty leaves.
        """
        leaving = self._leaving(self._drawn(number), gains)
        return "" if leaving <= MOST_LEAVING * DRAWS else _leaves(leaving)

    def _beside_safe(
        self,
        point: NDArray[np.float64],
        inside: list[Trial],
        leaving: int,
        smallest: tuple[Mapping[str, float], int],
    ) -> Doubted:
        """Repeat the nearest run that stayed inside; after its repetition, the smallest step.

        The axis overrules twins that leave the envelope where it stayed inside. Otherwise a twin
        that is too cautious would have the same gains run for ever.
        """
        at = [self.history.unit_point(one.gains) for one in inside]
        nearest = int(np.argmin([((one - point) ** 2).sum() for one in at]))
        safe = inside[nearest]
        if sum(_same(one, at[nearest]) for one in at) == 1:
            told = (
                f"{_withheld(leaving)}; nothing on the way to trial {safe.number} is safer, so "
                "its gains are repeated: it stayed inside"
            )
            return Doubted(dict(safe.gains), leaving, True, told)
        step, count = smallest
        inside_twice = (
            f"a small step from trial {safe.number}, which stayed inside and again when repeated"
        )
        if _same(self.history.unit_point(step), point):
            return Doubted(step, leaving, False, f"{_leaves(leaving)}, {inside_twice}")
        told = f"{_withheld(leaving)}; {count} of {DRAWS} leave it at these too, {inside_twice}"
        return Doubted(step, leaving, True, told)

    def _inside(self, state: TuningState) -> list[Trial]:
        """Real runs that stayed inside, at the held values where gains are held."""
        unit_point = self.history.unit_point
        real = self.history.of("IS1")
        runs = [trial for trial in real if trial.status == "ok" and not trial.bare]
        points = [unit_point(trial.gains) for trial in runs]
        return [run for run, at in zip(runs, points, strict=True) if _same(at, state.hold(at))]

    def _way(
        self, point: NDArray[np.float64], inside: list[Trial], state: TuningState
    ) -> list[Mapping[str, float]]:
        """Gains ever nearer to the nearest safe ones, without both ends; empty without safe ones.

        Known-safe gains at which the axis left the envelope are none.
        """
        history = self.history
        left = [history.unit_point(t.gains) for t in history.of("IS1") if t.status == "unsafe"]
        starts = [one for one in history.caution.starts if not any(_same(one, o) for o in left)]
        safe = [*starts, *(history.unit_point(trial.gains) for trial in inside)]
        if not safe:
            return []
        held = state.hold(np.stack(safe))
        near = held[int(np.argmin(((held - point) ** 2).sum(axis=1)))]
        way = [
            history.gains_at(near + (point - near) * 0.5**halving)
            for halving in range(1, HALVINGS + 1)
        ]
        # Gains that take single values may leave no step between the ends.
        between = (one for one in way if not _same(history.unit_point(one), near))
        return [one for one in between if not _same(history.unit_point(one), point)]

    def _drawn(self, number: int) -> list[Source]:
        return [self._draw(number, draw) for draw in range(DRAWS)]

    def _draw(self, number: int, draw: int) -> Source:
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


def _same(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool(np.abs(one - other).max() <= SAME_POINT)


def _withheld(leaving: int) -> str:
    return (
        f"the gains first proposed were withheld: {leaving} of {DRAWS} believed twins "
        "left the envelope there"
    )


def _leaves(leaving: int) -> str:
    return f"{leaving} of {DRAWS} believed twins leave the envelope at these gains"
