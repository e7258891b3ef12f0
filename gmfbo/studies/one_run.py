"""One run of a comparison: a method on a seed, judged against the true optimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.recordings.store.memory_store import MemoryStore, StudyRecord
from gmfbo.recordings.store.trial import Trial
from gmfbo.studies.goal import Descent, Goal
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import TrueSources
from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.query_cost import IS1_COST, TWIN_COST
from gmfbo.tuning.query.method import Method
from gmfbo.tuning.query.progress import Progress
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.study_sections import StudyFile
from gmfbo.tuning.tuner import Tuner
from gmfbo.version import __version__

PAPER_QUERIES = 20
"""N of the publication: queries of both sources after the initial data."""


@dataclass(frozen=True, eq=False)
class OneRun:
    """A study to run.

    Attributes
    ----------
    study : Study
        With its seed, and a folder for files of its method.
    key : str
        Hash of the content that all runs of the comparison share.
    method : Method
        Method that proposes.
    truth : Path
        Folder of the plant's grids.
    side : int
        Points along a side of the grid of the true optimum.
    """

    study: Study
    key: str
    method: Method
    truth: Path
    side: int

    def run(self) -> tuple[Outcome, StudyRecord]:
        """Run the study from its beginning, in memory, and judge it.

        Returns
        -------
        outcome : Outcome
            Outcome of the run.
        record : StudyRecord
            All its trials.
        """
        store = MemoryStore(self.study.location, self.study.text)
        stamps = _Stamps([], [])
        with Tuner(self.study, method=self.method, store=store) as tuner:
            tuner.run(stamps.take)
            return self._outcome(tuner.history, stamps), store.record

    def _outcome(self, history: History, stamps: _Stamps) -> Outcome:
        budget, change = self.study.file.budget, self.study.file.is1.change
        after = change.after_runs if change else None
        goals, costs = _judged(self.study, history, self.side, self.truth)
        descent = Descent.of(costs, goals, after)
        within = _real_runs_within(history.trials, stamps.queries, PAPER_QUERIES)
        most = budget.is1_runs or budget.initial_is1 + budget.most_queries
        return Outcome(
            study=self.key,
            method=self.method.name,
            seed=self.study.file.seed,
            n_star=descent.arrival(),
            n_star_paper=descent.arrival(within),
            most_real_runs=most,
            least=_short(goals[-1].least),
            median=_short(goals[-1].median),
            best=tuple(map(_short, descent.best)),
            regret=tuple(map(_short, descent.regret)),
            cost=_cost_by_query(history.trials, stamps.queries),
            seconds=stamps.each,
            seconds_before=_short(stamps.began),
            twin_runs=len(history.of("IS2")),
            corrected_runs=len(history.of("IS3")),
            version=__version__,
            alarms=tuple(drift.found_at for drift in history.drifts),
        )


@dataclass
class _Stamps:
    queries: list[int]
    ends: list[float]
    began: float = 0.0
    """[s] End of the initial data."""

    def take(self, step: Progress) -> None:
        if step.phase == "initial":
            self.began = step.seconds
        elif step.phase == "query":
            self.queries.append(step.trial)
            self.ends.append(step.seconds)

    @property
    def each(self) -> tuple[float, ...]:
        starts = [self.began, *self.ends]
        return tuple(_short(b - a) for a, b in zip(starts, self.ends, strict=False))


def seeded(study: Study, seed: int, method: str, location: Path) -> Study:
    """Copy of a study with another seed, method and place."""
    return replace(study, file=seeded_file(study.file, seed, method), location=location)


def seeded_file(file: StudyFile, seed: int, method: str) -> StudyFile:
    """Copy of a study file with another seed and method, and a budget.

    Parameters
    ----------
    file : StudyFile
        As given; a budget without an end becomes the publication's.
    seed : int
        Of the copy.
    method : str
        Name of the copy's method.
    """
    budget = file.budget
    if budget.is1_runs is None and budget.iterations is None:
        budget = budget.model_copy(update={"is1_runs": budget.initial_is1 + 20})
    return file.model_copy(update={"seed": seed, "method": method, "budget": budget})


def make_truth(study: Study, side: int, truth: Path) -> None:
    """Run the plant, and the changed plant, over the box, unless done before."""
    opened = TrueSources.open(study)
    with closing(opened.sources):
        for plant in opened.plants:
            opened.grid(plant, side, truth)


def _judged(
    study: Study, history: History, side: int, truth: Path
) -> tuple[list[Goal], list[float]]:
    """Goals of the plant, and of the changed plant, and the noise-free cost g of each real run."""
    file, real = study.file, history.of("IS1")
    opened = TrueSources.open(study)
    with closing(opened.sources):
        given = opened.given
        if given is not None:
            goals = [Goal.over(_true_costs(history, given.metrics))]
        else:
            grids = [opened.grid(plant, side, truth) for plant in opened.plants]
            goals = [Goal.over(_true_costs(history, grid.metrics)) for grid in grids]
        if given is None and not file.is1.noise:
            # An FMU without noise repeats exactly: what is observed is the noise-free cost.
            return goals, [float(_true_costs(history, trial.metrics)) for trial in real]
        names, after = opened.gains.space.names, file.is1.change
        points = np.array([[trial.gains[name] for name in names] for trial in real])
        found = opened.noise_free(points, after.after_runs if after else None)
        return goals, [float(cost) for cost in _true_costs(history, found)]


def _true_costs(history: History, metrics: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
    """Cost g by which runs are judged, shape of a metric; beyond a limit, that of a failed run."""
    costs, limits = history.objective.value(metrics), history.limits
    met = np.ones(costs.shape, dtype=bool)
    for name, values in limits.limited(metrics).items():
        met &= ~(values > limits.most[name])  # a margin is the twin's: the plant's is unknown
    return np.where(met, costs, history.objective.failed)


def _cost_by_query(trials: Sequence[Trial], queries: Sequence[int]) -> tuple[float, ...]:
    """Cost [real runs] after the initial data, and after each query with all that it entailed.

    `queries` are the numbers of the trials that a method asked for, in order.
    """
    asked = set(queries)
    account = [0.0]
    for trial in trials:
        if trial.number in asked:
            account.append(account[-1])
        account[-1] += IS1_COST if trial.source == "IS1" else TWIN_COST
    return tuple(map(_short, account))


def _real_runs_within(trials: Sequence[Trial], queries: Sequence[int], most: int) -> int:
    """Real runs, initial ones counted, by the end of the first `most` queries of either source."""
    after = set(queries[most:])
    return sum(trial.source == "IS1" and trial.number not in after for trial in trials)


def _short(value: float) -> float:
    """Round to eight digits, enough to draw and compare, for a small text."""
    return float(f"{value:.8g}")
