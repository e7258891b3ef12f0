"""Role of each run of a study, from its trials and its log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.query_cost import IS1_COST, TWIN_COST
from gmfbo.tuning.study_file.study_sections import BudgetSection

Role = Literal[
    "initial", "survey", "earlier", "query", "renewed", "beside", "closer", "corrected", "rejected"
]

ROLES: Mapping[Role, str] = {
    "initial": "initial data",
    "survey": "survey of the box",
    "earlier": "of an earlier study",
    "query": "asked for by the method",
    "renewed": "made again by a corrected twin",
    "beside": "beside a real run",
    "closer": "a closer look where it is promising",
    "corrected": "corrected, around a real run",
    "rejected": "corrected, but too uncertain",
}
"""Name of each role."""


@dataclass(frozen=True, eq=False)
class Run:
    """A run and its place in the study.

    Attributes
    ----------
    trial : Trial
        As it is stored.
    role : str
        One of `ROLES`.
    query : int
        Queries of the method up to this run; 0 with the initial data.
    cost : float
        [real runs] Cost of all runs up to this one.
    """

    trial: Trial
    role: Role
    query: int
    cost: float


def placed_runs(
    trials: Sequence[Trial], events: Sequence[Mapping[str, Any]], budget: BudgetSection
) -> tuple[Run, ...]:
    """Give each trial its role, query and cost; trials come in order of their numbers."""
    asked = {event["number"] for event in events if event["event"] == "ask"}
    begun = [event for event in events if event["event"] == "earlier"]
    earlier_runs = len(begun[-1]["trials"]) if begun else 0
    first_twin = next((t.twin for t in trials if t.source == "IS2" and t.parent is None), "")
    real, twin, query, cost = 0, 0, 0, 0.0
    gains_of = {trial.number: trial.gains for trial in trials if trial.source == "IS1"}
    placed = []
    for trial in trials:
        if trial.source == "IS1":
            real += 1
            earlier = real <= earlier_runs
            role: Role = "earlier" if earlier else "initial"
            if real > max(budget.initial_is1, earlier_runs):
                role = "query"
            cost += 0.0 if earlier else IS1_COST
        else:
            cost += TWIN_COST
            role = _twin_role(
                trial,
                real=gains_of.get(trial.parent or 0),
                asked=trial.number in asked,
                initial=twin < budget.initial_is2,
                renewed=trial.twin != first_twin,
            )
            twin += trial.source == "IS2"
        query += role == "query"
        placed.append(Run(trial, role, query, cost))
    return tuple(placed)


def _twin_role(
    trial: Trial, *, real: Mapping[str, float] | None, asked: bool, initial: bool, renewed: bool
) -> Role:
    """Role of a twin run, by its request and the gains of the real run that caused it."""
    if trial.source == "IS3":
        return "rejected" if trial.accepted is False else "corrected"
    if trial.parent is not None:
        return "beside" if trial.gains == real else "closer"
    if asked:
        return "query"
    if renewed:
        return "renewed"
    return "initial" if initial else "survey"
