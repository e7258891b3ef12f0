"""Requests for runs, and the result of a study."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.query.method import Recommendation

if TYPE_CHECKING:
    from gmfbo.tuning.drift.drift import Drift


@dataclass(frozen=True)
class TrialRequest:
    """A request for a run.

    Attributes
    ----------
    number : int
        Of the trial that it becomes.
    source : {"IS1", "IS2"}
        Source of the run; `Tuner.ask` runs the twin itself, and returns real runs only.
    gains : mapping of str to float
        All gains by name [unit of the FMU parameter].
    mismatch : float or None
        Mismatch e of the twin that the method used, dimensionless.
    note : str
        Note of the method; usually empty.
    """

    number: int
    source: Literal["IS1", "IS2"]
    gains: Mapping[str, float]
    mismatch: float | None = None
    note: str = ""

    @classmethod
    def unanswered(
        cls, events: Sequence[Mapping[str, Any]], made: Collection[int]
    ) -> list[TrialRequest]:
        """Find the logged requests that have not become trials yet, in order.

        Parameters
        ----------
        events : sequence of mapping
            Of the study's log; of several requests of one number the last counts.
        made : collection of int
            Numbers of the trials on disk.
        """
        asked = {event["number"]: event for event in events if event["event"] == "ask"}
        last = max(asked, default=0)
        repairs = [event for event in events if event["event"] == "repair"]
        # A run whose file was damaged had been made; only the last one is asked for again.
        lost = {n for event in repairs for n in event.get("lost_trials", ())} - {last}
        made = {*made, *lost}
        return [
            cls(one["number"], one["source"], one["gains"], one["mismatch"], one["note"])
            for number, one in sorted(asked.items())
            if number not in made
        ]


@dataclass(frozen=True)
class TuningResult:
    """Result of a study.

    Attributes
    ----------
    best : Trial or None
        Real run with the least cost; None when none succeeded.
    recommendation : Recommendation or None
        Gains at which the surrogate expects the least cost; None without a real run.
    is1_runs : int
        Number of real runs, initial ones included.
    earlier, left_out : int
        Number of real runs of an earlier study that were taken over, and that were not.
    is2_runs : int
        Number of runs of the twin, initial ones and those beside real runs included.
    queries : int
        Queries of either source after the initial ones.
    cost : float
        Cost of all runs, in units of a real run.
    drifts : tuple of Drift
        Detected changes of the plant, in order; `best` is from after the last.
    twin_versions : tuple of str
        Reasons of the twin's corrections, in order.
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
    is2_runs: int = 0
