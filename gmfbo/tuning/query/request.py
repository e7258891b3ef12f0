"""Requests for runs, and the result of a study."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Self

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.remarks import (
    ended_early,
    last_failure,
    remarks_on,
    unmet_limits,
    worth_remarks,
)
from gmfbo.tuning.query.method import Recommendation

if TYPE_CHECKING:
    from gmfbo.tuning.drift.drift import Drift
    from gmfbo.tuning.history.history import History


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
    expected : tuple of float or None
        Predicted cost g of the real run, and its standard deviation; None where it is unknown.
    """

    number: int
    source: Literal["IS1", "IS2"]
    gains: Mapping[str, float]
    mismatch: float | None = None
    note: str = ""
    expected: tuple[float, float] | None = None

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
        return [cls._logged(one) for number, one in sorted(asked.items()) if number not in made]

    @classmethod
    def _logged(cls, event: Mapping[str, Any]) -> TrialRequest:
        expected = event.get("expected")  # studies of former versions did not log it
        return cls(
            event["number"],
            event["source"],
            event["gains"],
            event["mismatch"],
            event["note"],
            None if expected is None else (expected[0], expected[1]),
        )


@dataclass(frozen=True)
class TuningResult:
    """Result of a study.

    Attributes
    ----------
    best : Trial or None
        Real run with the least cost, or while none settled the one nearest to it; None when none
        succeeded.
    recommendation : Recommendation or None
        Gains to take: by the method's rule, mostly those that were tried and have the least
        expected cost. None where no real run settled.
    is1_runs : int
        Number of real runs, initial ones included.
    earlier, left_out : int
        Number of real runs of an earlier study that were taken over, and that were not.
    why_left_out : tuple of str
        Reasons for which they were not, each with its number.
    is2_runs : int
        Number of runs of the twin, initial ones and those beside real runs included.
    is3_runs : int
        Number of corrected runs of the twin.
    queries : int
        Queries of either source after the initial ones.
    cost : float
        Cost of all runs, in units of a real run.
    drifts : tuple of Drift
        Detected changes of the plant, in order; `best` is from after the last.
    twin_versions : tuple of str
        Reasons of the twin's corrections, in order.
    learned : tuple of str
        What the last of them has learned: parameters from -> to with interval, physics with
        probability.
    settled : bool
        Whether a real run settled; True in studies that do not ask for it.
    remarks : tuple of str
        Failed runs, limits that no run meets, metrics without a say, gains at their bounds, and
        queries that were used up before the real runs.
    unmet : tuple of str
        Limits that the recommended gains do not meet.
    last_failure : str
        Why the last real run that failed did; empty where none failed.
    """

    best: Trial | None
    recommendation: Recommendation | None
    is1_runs: int
    queries: int
    cost: float
    drifts: tuple[Drift, ...] = ()
    earlier: int = 0
    left_out: int = 0
    why_left_out: tuple[str, ...] = ()
    twin_versions: tuple[str, ...] = ()
    learned: tuple[str, ...] = ()
    is2_runs: int = 0
    is3_runs: int = 0
    settled: bool = True
    remarks: tuple[str, ...] = ()
    unmet: tuple[str, ...] = ()
    last_failure: str = ""

    @classmethod
    def of(
        cls,
        history: History,
        recommendation: Recommendation | None,
        *,
        earlier: int,
        why_left_out: tuple[str, ...],
        twin_versions: tuple[str, ...],
        learned: tuple[str, ...] = (),
    ) -> Self:
        """Result as of now.

        Parameters
        ----------
        history : History
            Of the study.
        recommendation : Recommendation or None
            Gains to take.
        earlier : int
            Real runs of an earlier study that were taken over.
        why_left_out : tuple of str
            How many were not, and why.
        twin_versions : tuple of str
            Reasons of the twin's corrections, in order.
        learned : tuple of str
            What the last of them has learned.
        """
        real, words = history.of("IS1"), history.metric_words
        return cls(
            best=history.best,
            recommendation=recommendation,
            is1_runs=history.made,
            is2_runs=len(history.of("IS2")),
            is3_runs=len(history.of("IS3")),
            queries=history.queries,
            cost=history.cost,
            drifts=tuple(history.drifts),
            earlier=earlier,
            left_out=sum(int(why.partition(":")[0]) for why in why_left_out),
            why_left_out=why_left_out,
            twin_versions=twin_versions,
            learned=learned,
            settled=history.settled or not history.ranked,
            remarks=(
                *remarks_on(history.study, real, history.best, history.gains.space, words),
                *ended_early(history.study.budget, history.queries, history.made),
                *worth_remarks(history.store.events()),
            ),
            unmet=unmet_limits(recommendation.gains, real, history.limits, words)
            if recommendation
            else (),
            last_failure=last_failure(real),
        )
