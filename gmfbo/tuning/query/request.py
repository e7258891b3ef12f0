"""Runs that are wanted, and the results of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.query.method import Recommendation

if TYPE_CHECKING:
    from gmfbo.tuning.drift.drift import Drift


@dataclass(frozen=True)
class TrialRequest:
    """A run that is wanted.

    Attributes
    ----------
    number : int
        Of the trial that it becomes.
    source : {"IS1", "IS2"}
        Who shall run; `Tuner.ask` runs the twin itself and returns real runs only.
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    mismatch : float or None
        Mismatch e of the twin by which the method decided, dimensionless.
    note : str
        What the method had to say; usually empty.
    """

    number: int
    source: Literal["IS1", "IS2"]
    gains: Mapping[str, float]
    mismatch: float | None = None
    note: str = ""

    @classmethod
    def unanswered(cls, events: list[dict[str, Any]], next_number: int) -> TrialRequest | None:
        """Find the request that was logged last and never became a trial.

        Parameters
        ----------
        events : list of dict
            The study's log.
        next_number : int
            Number of the trial that comes next.
        """
        asked = [event for event in events if event.get("event") == "ask"]
        if not asked or asked[-1]["number"] != next_number:
            return None
        last = asked[-1]
        return cls(last["number"], last["source"], last["gains"], last["mismatch"], last["note"])


@dataclass(frozen=True)
class TuningResult:
    """What a study came to.

    Attributes
    ----------
    best : Trial or None
        Real run with the least cost; None when none succeeded.
    recommendation : Recommendation or None
        Where the surrogate expects the least cost; None when no real run was made.
    is1_runs : int
        Real runs, initial ones counted.
    earlier, left_out : int
        Real runs taken over from an earlier study, and those of it that were not.
    queries : int
        Queries of either source after the initial ones.
    cost : float
        All runs in units of a real run.
    drifts : tuple of Drift
        Changes of the plant that were found, in order; `best` is since the last one.
    twin_versions : tuple of str
        Why the twin was corrected, each time.
    """

    best: Trial | None
    recommendation: Recommendation | None
    is1_runs: int
    queries: int
    cost: float
    drifts: tuple[Drift, ...] = ()
    earlier: int = 0
    left_out: int = 0
    twin_versions: tuple[str, ...] = ()
