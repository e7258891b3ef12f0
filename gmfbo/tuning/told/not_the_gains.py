"""Real runs that failed for another reason than their gains: the same trial is asked again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from gmfbo.errors import SimulationError

if TYPE_CHECKING:
    from gmfbo.recordings.store.memory_store import TrialStore

EVENT = "not_the_gains"

MOST_IN_A_ROW = 3
"""Such runs in a row after which a study stops: whoever is at the bench has to look."""


def log_not_the_gains(store: TrialStore, number: int, why: str) -> None:
    """Log a run that failed for another reason than its gains.

    Parameters
    ----------
    store : TrialStore
        Of the study.
    number : int
        Of the trial, which stays asked for.
    why : str
        Reason, in a few words.

    Raises
    ------
    SimulationError
        It is the third in a row; the log holds it.
    """
    why = " ".join(why.split())
    store.log(EVENT, number=number, why=why)
    # A study that was stopped and goes on has three tries again.
    if in_a_row(store.events()) % MOST_IN_A_ROW == 0:
        raise SimulationError(
            f"trial {number}: {MOST_IN_A_ROW} runs in a row failed for another reason than their "
            f"gains (the last: {why}); mend the bench and go on: the same gains are asked again "
            "('gmfbo tune --resume', or 'gmfbo ask')"
        )


def in_a_row(events: Iterable[Mapping[str, Any]]) -> int:
    """Number of such runs since the last run that was told.

    Parameters
    ----------
    events : iterable of mapping
        The study's log.
    """
    count = 0
    for event in events:
        if event["event"] == EVENT:
            count += 1
        elif event["event"] == "tell":
            count = 0
    return count
