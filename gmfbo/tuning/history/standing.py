"""What of a study still counts: runs that were taken back stay on disk, and are left out here."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gmfbo.recordings.store.trial import Trial

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore

UNDO = "undo"
"""Event that takes back a told run."""

END = "end"
"""Event that nothing more was to be asked for; the study may go on with more budget."""

# What was concluded from a run falls with it.
_CONCLUSIONS = ("drift", "twin_version", "recommendation", END)


def undone_numbers(events: Sequence[Mapping[str, Any]]) -> frozenset[int]:
    """Numbers of the trials that were taken back, those made because of them included.

    Parameters
    ----------
    events : sequence of mapping
        Of the study's log.
    """
    return frozenset(n for event in events if event["event"] == UNDO for n in event["trials"])


def standing_events(
    events: Sequence[dict[str, Any]], made: Collection[int]
) -> list[dict[str, Any]]:
    """Events that still count, in order.

    With a run fall its `tell`, what was concluded between it and its `undo`, and what was asked
    for meanwhile and not made.

    Parameters
    ----------
    events : sequence of dict
        Of the study's log.
    made : collection of int
        Numbers of all trials on disk.
    """
    kept: list[dict[str, Any]] = []
    for event in events:
        if event["event"] != UNDO:
            kept.append(event)
            continue
        told = next(
            place
            for place, one in reversed(list(enumerate(kept)))
            if one["event"] == "tell" and one["number"] == event["number"]
        )
        since = [
            one
            for one in kept[told + 1 :]
            if one["event"] not in _CONCLUSIONS
            and not (one["event"] == "ask" and one["number"] not in made)
        ]
        kept = [*kept[:told], *since]
    return kept


def in_order(trials: Sequence[Trial], events: Sequence[Mapping[str, Any]]) -> list[Trial]:
    """Trials in the order in which they were made.

    That is the order of their numbers, unless several runs were asked for at once and told in
    another order: each `tell` names the highest trial that was on disk before it.

    Parameters
    ----------
    trials : sequence of Trial
        In the order of their numbers.
    events : sequence of mapping
        Of the study's log.
    """
    told = {
        event["number"]: (event.get("after", 0), place)
        for place, event in enumerate(events)
        if event["event"] == "tell"
    }

    def key(trial: Trial) -> tuple[int, int]:
        after, place = told.get(trial.number, (0, 0))
        return (trial.number, 0) if trial.number > after else (after, 1 + place)

    return sorted(trials, key=key)


def real_runs_at_ask(events: Sequence[Mapping[str, Any]], real: Sequence[Trial]) -> int | None:
    """Number of real runs when the last query was decided on; None before the first.

    Parameters
    ----------
    events : sequence of mapping
        Of the study's log, those that stand.
    real : sequence of Trial
        Real runs that count.
    """
    asked = [event for event in events if event["event"] == "ask"]
    if not asked:
        return None
    # Studies of former versions asked for one run at a time, and told it before the next.
    before = sum(trial.number < asked[-1]["number"] for trial in real)
    return int(asked[-1].get("real", before))


class StandingStore:
    """A store that shows only what still counts, and writes everything.

    Parameters
    ----------
    store : TrialStore
        Open for writing.

    Attributes
    ----------
    location : Path
        Folder of the study.
    numbers : set of int
        Numbers of all trials on disk, taken back or not.
    """

    def __init__(self, store: TrialStore) -> None:
        self._store = store
        self.location: Path = store.location
        self.numbers = {trial.number for trial in store.trials()}

    @property
    def highest(self) -> int:
        """Highest number of a trial on disk, taken back or not; 0 without any."""
        return max(self.numbers, default=0)

    def trials(self) -> list[Trial]:
        """Trials that count, in the order in which they were made."""
        events = self._store.events()
        undone = undone_numbers(events)
        return in_order([t for t in self._store.trials() if t.number not in undone], events)

    def events(self) -> list[dict[str, Any]]:
        """Events that count, in order."""
        events = self._store.events()
        if not any(event["event"] == UNDO for event in events):
            return events
        return standing_events(events, self.numbers)

    def write_trial(self, trial: Trial) -> object:
        """Keep a finished trial.

        Parameters
        ----------
        trial : Trial
            Its number must be free.
        """
        written = self._store.write_trial(trial)
        self.numbers.add(trial.number)
        return written

    def log(self, event: str, **fields: Any) -> None:
        """Keep an event.

        Parameters
        ----------
        event : str
            Name of the event.
        **fields
            JSON values, or NumPy values.
        """
        self._store.log(event, **fields)

    def refresh_index(self) -> None:
        """Update the list of trials."""
        self._store.refresh_index()
