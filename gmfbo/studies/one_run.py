"""One method on one seed: the study is run, judged against the truth, and put away."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo import __version__
from gmfbo.recordings.trial import Trial
from gmfbo.studies.goal import Descent, Goal
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.plant_grid import TrueSources
from gmfbo.tuning.history import History
from gmfbo.tuning.method import Method
from gmfbo.tuning.progress import Progress
from gmfbo.tuning.query_cost import IS1_COST, TWIN_COST
from gmfbo.tuning.study import Study
from gmfbo.tuning.tuner import Tuner

PAPER_QUERIES = 20
"""N of the publication: queries of either source after the initial data."""


@dataclass(frozen=True, eq=False)
class OneRun:
    """A study to be run.

    Attributes
    ----------
    study : Study
        As given; seed and method are those below.
    key : str
        Hash of what all runs of the comparison share.
    method : Method
        Who proposes.
    seed : int
        Of the study.
    folder : Path
        Of the comparison.
    side : int
        Points along a side of the grid that gives the truth.
    """

    study: Study
    key: str
    method: Method
    seed: int
    folder: Path
    side: int

    @property
    def label(self) -> str:
        """Names the run, and its files."""
        return f"{self.method.name}-{self.seed}"

    @property
    def kept(self) -> Path:
        """Text of the finished run."""
        return self.folder / "runs" / f"{self.label}.json"

    def run(self) -> Outcome:
        """Run the study from its beginning, and keep what it came to.

        A run that was killed is made again: half of it would spoil its times.
        """
        place = self.folder / "running" / self.label
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        study = seeded(self.study, self.seed, self.method.name, place / "run.study")
        stamps = _Stamps([], [])
        with Tuner(study, method=self.method) as tuner:
            tuner.run(stamps.take)
            goals = true_goals(study, tuner.history, self.side, self.folder)
            outcome = self._outcome(tuner.history, goals, stamps)
        self.kept.parent.mkdir(exist_ok=True)
        outcome.save(self.kept)
        shutil.rmtree(place, ignore_errors=True)
        return outcome

    def _outcome(self, history: History, goals: Sequence[Goal], stamps: _Stamps) -> Outcome:
        budget, change = self.study.file.budget, self.study.file.is1.change
        real = history.of("IS1")
        descent = Descent.of(
            # A plant that is an FMU repeats exactly: what is observed is the noise-free cost.
            [float(true_costs(history, trial.metrics)) for trial in real],
            goals,
            change.after_runs if change else None,
        )
        within = real_runs_within(history.trials, stamps.queries, PAPER_QUERIES)
        most = budget.is1_runs or budget.initial_is1 + budget.most_queries
        return Outcome(
            study=self.key,
            method=self.method.name,
            seed=self.seed,
            n_star=descent.arrival(),
            n_star_paper=descent.arrival(within),
            most_real_runs=most,
            least=_short(goals[-1].least),
            median=_short(goals[-1].median),
            best=tuple(map(_short, descent.best)),
            regret=tuple(map(_short, descent.regret)),
            cost=cost_by_query(history.trials, stamps.queries),
            seconds=stamps.each,
            seconds_before=_short(stamps.began),
            twin_runs=len(history.of("IS2")),
            corrected_runs=len(history.of("IS3")),
            version=__version__,
        )


@dataclass
class _Stamps:
    """When each query was done."""

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
    """Copy of a study with another seed, method and place.

    Parameters
    ----------
    study : Study
        As given.
    seed : int
        Of the copy.
    method : str
        Name of the copy's method.
    location : Path
        Folder of the copy.
    """
    budget = study.file.budget
    if budget.is1_runs is None and budget.iterations is None:
        budget = budget.model_copy(update={"is1_runs": budget.initial_is1 + 20})
    file = study.file.model_copy(update={"seed": seed, "method": method, "budget": budget})
    return replace(study, file=file, location=location)


def true_goals(study: Study, history: History, side: int, folder: Path) -> list[Goal]:
    """Goals of the plant, and of the changed plant, by the study's own cost.

    Parameters
    ----------
    study : Study
        With its seed.
    history : History
        With its cost's constants, which come from the initial runs of the twin.
    side : int
        Points along a side of the grid.
    folder : Path
        Of the comparison, where grids are kept.
    """
    opened = TrueSources.open(study)
    with closing(opened.sources):
        grids = [opened.grid(plant, side, folder / "truth") for plant in opened.plants]
    return [Goal.over(true_costs(history, grid.metrics)) for grid in grids]


def true_costs(history: History, metrics: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
    """Cost by which runs are judged; breaking a limit counts as failing.

    Parameters
    ----------
    history : History
        With its cost's constants and limits.
    metrics : mapping of str to array_like, shape (...)
        Of runs [% or s].
    """
    costs, limits = history.objective.value(metrics), history.limits
    met = np.ones(costs.shape, dtype=bool)
    for name, values in limits.limited(metrics).items():
        met &= values <= limits.most[name]
    return np.where(met, costs, history.objective.failed)


def cost_by_query(trials: Sequence[Trial], queries: Sequence[int]) -> tuple[float, ...]:
    """Cost after the initial data, and after each query with all runs that it entailed.

    Parameters
    ----------
    trials : sequence of Trial
        All runs in order.
    queries : sequence of int
        Numbers of the trials that a method asked for, in order.

    Returns
    -------
    tuple of float
        One more than queries; in units of a real run: 1 for IS1, 0.1 for IS2 and IS3.
    """
    asked = set(queries)
    account = [0.0]
    for trial in trials:
        if trial.number in asked:
            account.append(account[-1])
        account[-1] += IS1_COST if trial.source == "IS1" else TWIN_COST
    return tuple(map(_short, account))


def real_runs_within(trials: Sequence[Trial], queries: Sequence[int], most: int) -> int:
    """Real runs, initial ones counted, by the end of a number of queries.

    Parameters
    ----------
    trials : sequence of Trial
        All runs in order.
    queries : sequence of int
        Numbers of the trials that a method asked for, in order.
    most : int
        Queries of either source.
    """
    after = set(queries[most:])
    return sum(trial.source == "IS1" and trial.number not in after for trial in trials)


def _short(value: float) -> float:
    """Eight digits: enough to draw and to compare, and a small text."""
    return float(f"{value:.8g}")
