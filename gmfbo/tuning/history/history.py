"""History of a study: its runs, written to disk before they count, and derived values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import OwnMetricsError
from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.objective.metric_units import units_of_metrics
from gmfbo.objective.metric_words import MetricWords
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.store.trial import SourceName, Trial
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.joined_runs import ended_by
from gmfbo.tuning.experiment.loop_margins import MarginMeter
from gmfbo.tuning.history.caution import Caution
from gmfbo.tuning.history.constants import objective_of
from gmfbo.tuning.history.incumbent import best_run, has_settled
from gmfbo.tuning.history.keep_out import KeepOut
from gmfbo.tuning.history.known_margins import KnownMargins
from gmfbo.tuning.history.observing import aged, observed
from gmfbo.tuning.history.query_cost import IS1_COST, TWIN_COST
from gmfbo.tuning.history.ranked import by_rank
from gmfbo.tuning.history.standing import StandingStore, real_runs_at_ask
from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.history.trials_by_source import TrialsBySource
from gmfbo.tuning.history.twin_budget import EVENT, TwinBudget
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.study_file.study_sections import StudyFile


class History:
    """Trials of one study in order, with their costs.

    Everything here follows from the trials on disk, so that a killed study resumes exactly.

    Parameters
    ----------
    store : StandingStore
        Open for writing.
    study : StudyFile
        The validated file.
    experiment : ExperimentSeries
        Experiment of every source.
    gains : GainChoice
        Tuned and held gains.
    survey : int
        Number of twin runs over the box before the first query.
    earlier : int
        Number of real runs taken over from an earlier study, which come first.
    meter : MarginMeter, optional
        Measures margins of the loop on the twin, where they are limited.
    ranked : bool
        Whether runs are ranked before their cost counts; otherwise a failed run has a price.
    starts : ndarray, shape (k, d), optional
        Gains in force and other known-safe ones, in the unit cube.
    limited : bool
        Whether real runs move from these by steps; see `Caution`.

    Attributes
    ----------
    twin : str or None
        Content hash of the present twin; None while it was never corrected.
    waiting : dict of int to mapping
        Gains of the real runs that were asked for and not told yet, by trial number.
    real_at_ask : int or None
        Number of real runs when the last query was decided on; None before the first.
    """

    def __init__(
        self,
        store: StandingStore,
        study: StudyFile,
        experiment: ExperimentSeries,
        gains: GainChoice,
        *,
        survey: int = 0,
        earlier: int = 0,
        meter: MarginMeter | None = None,
        ranked: bool = False,
        starts: NDArray[np.float64] | None = None,
        limited: bool = False,
    ) -> None:
        self.store, self.study, self.experiment, self.gains = store, study, experiment, gains
        self.survey, self.earlier, self.ranked = survey, earlier, ranked
        self.margins = KnownMargins(meter, store)
        self.limits, self.envelope = Limits(study.constraints), study.safety.envelope
        starts = np.empty((0, len(gains.space))) if starts is None else starts
        self.caution = Caution(gains.space, self.envelope, starts, limited and len(starts) > 0)
        self.twin_budget = TwinBudget(study.budget, ranked)
        self.trials: list[Trial] = store.trials()
        self._by_source = TrialsBySource()
        self.waiting: dict[int, Mapping[str, float]] = {}
        self.twin: str | None = None
        events = store.events()
        self.drifts = [Drift.logged(event) for event in events if event["event"] == "drift"]
        self.real_at_ask = real_runs_at_ask(events, self.of("IS1"))
        for event in events:
            if event["event"] == "ask":
                self.note_expected(event["number"], event.get("expected"))
            if event["event"] == EVENT:
                self.twin_budget.other_seconds += event["seconds"]
        self._observations: list[tuple[Trial, Observation]] = []
        self._seen = 0
        self._objective: Objective | None = None
        if len(self.of("IS2")) >= study.budget.initial_is2:
            self.normalise(self.of("IS2")[: study.budget.initial_is2])

    def note_expected(self, number: int, expected: Sequence[float] | None) -> None:
        """Remember mean and std of the cost that was predicted for a request, if any was."""
        if expected is not None:
            self.caution.expected[number] = (expected[0], expected[1])

    def of(self, *sources: SourceName) -> list[Trial]:
        """Trials of some sources, in order."""
        if len(sources) == 1:
            return self._by_source.of(self.trials, sources[0])
        return [trial for trial in self.trials if trial.source in sources]

    def children(self, parent: Trial, source: SourceName) -> list[Trial]:
        """Runs of one source caused by a real run, with the present twin."""
        return [
            trial
            for trial in self.of(source)
            if trial.parent == parent.number and self.is_current(trial)
        ]

    def is_current(self, trial: Trial) -> bool:
        """Whether a run is of the real axis or of the present twin."""
        return trial.source == "IS1" or self.twin is None or trial.twin == self.twin

    @property
    def unprompted(self) -> list[Trial]:
        """Twin runs not caused by a real run: initial ones, survey and queries.

        Repetitions by a corrected twin are not among them.
        """
        runs = [trial for trial in self.of("IS2") if trial.parent is None]
        return [trial for trial in runs if trial.twin == runs[0].twin]

    def gains_at(self, unit: NDArray[np.float64]) -> dict[str, float]:
        """All gains by name at a point of the unit cube, shape (d,)."""
        return self.gains.values(self.gains.space.from_unit(unit))

    def unit_point(self, gains: Mapping[str, float]) -> NDArray[np.float64]:
        """Point of the unit cube, shape (d,), from all gains by name."""
        return self.gains.space.to_unit(self.gains.point(gains))

    @property
    def next_number(self) -> int:
        """Number of the next trial."""
        return max(self.store.highest, *self.waiting, 0) + 1

    @property
    def fresh(self) -> list[Trial]:
        """Real runs told since the last query was decided on; before the first, the last one."""
        real = self.of("IS1")
        begin = len(real) if self.real_at_ask is None else self.real_at_ask
        return real[min(begin, len(real) - 1) :]

    @property
    def made(self) -> int:
        """Number of real runs of this study, with initial and without taken-over ones."""
        return max(len(self.of("IS1")) - self.earlier, 0)

    @property
    def first_runs(self) -> int:
        """Number of runs before the first query: initial ones of both sources, and the survey."""
        budget = self.study.budget
        return max(budget.initial_is1 - self.earlier, 0) + budget.initial_is2 + self.survey

    @property
    def queries(self) -> int:
        """Number of queries of both sources, without initial, survey, paired and IS3 runs."""
        budget, twin = self.study.budget, len(self.unprompted) - self.survey
        real, initial = len(self.of("IS1")), max(budget.initial_is1, self.earlier)
        return max(twin - budget.initial_is2, 0) + max(real - initial, 0)

    @property
    def used_up(self) -> bool:
        """Whether the budget allows no further query; runs that are waited for count."""
        budget, waiting = self.study.budget, len(self.waiting)
        real = len(self.of("IS1")) + waiting
        if real < budget.initial_is1:
            return False
        if budget.is1_runs is not None and self.made + waiting >= budget.is1_runs:
            return True
        beyond_initial = min(waiting, max(real - max(budget.initial_is1, self.earlier), 0))
        return self.queries + beyond_initial >= budget.most_queries

    @property
    def twin_used_up(self) -> bool:
        """Whether the twin may not run again."""
        return self.twin_budget.used_up(self.trials)

    @property
    def cost(self) -> float:
        """Cost of all runs so far, in units of a real run."""
        return IS1_COST * self.made + TWIN_COST * len(self.of("IS2", "IS3"))

    @property
    def best(self) -> Trial | None:
        """Real run with the least cost since the plant changed, if possible within the limits."""
        return best_run(self.of("IS1"), self.limits, self.changed_after)

    @property
    def settled(self) -> bool:
        """Whether a real run settled."""
        return any(has_settled(trial) for trial in self.of("IS1"))

    @property
    def metric_words(self) -> MetricWords:
        """Words for metrics."""
        units = self.units_of(self.trials[0].recording) if self.trials else {}
        worst = self._objective.worst if self._objective else {}
        return MetricWords.of(units, worst, [one.horizon for one in self.study.references])

    @property
    def changed_after(self) -> int:
        """Trial number of the last real run before the newest change of the plant; 0 without."""
        return self.drifts[-1].last_before if self.drifts else 0

    def units_of(self, run: Recording) -> dict[str, str]:
        """Unit of each metric of ours, by the signals of a run (a `Recording`)."""
        names = (self.experiment.signal, self.experiment.terms.command or "")
        return units_of_metrics(*(run.units.get(name, "") for name in names))

    @property
    def objective(self) -> Objective:
        """The objective; known once the initial twin runs are done."""
        if self._objective is None:
            raise RuntimeError("the cost is asked for before the initial twin runs are complete")
        return self._objective

    @property
    def normalised(self) -> bool:
        """Whether the initial twin runs are complete."""
        return self._objective is not None

    def normalise(self, initial: list[Trial]) -> None:
        """Set the constants of the cost by the initial twin runs.

        Parameters
        ----------
        initial : list of Trial
            With metrics; their costs may be missing.

        Raises
        ------
        SimulationError
            All of them failed.
        """
        self._objective = objective_of(self.study, self.experiment, initial)

    def trial(
        self,
        source: SourceName,
        gains: Mapping[str, float],
        run: Recording,
        *,
        twin: str = "",
        parent: int | None = None,
        number: int | None = None,
        with_margins: bool = False,
    ) -> Trial:
        """Make a trial of a run; it is not yet on disk.

        Its cost is NaN until the initial twin runs are complete.

        Parameters
        ----------
        source : {"IS1", "IS2"}
            Source of the run.
        gains : mapping of str to float
            All gains by name.
        run : Recording
            Signals of the run.
        twin : str
            Content hash of the twin that ran.
        parent : int or None
            Real run that caused it.
        number : int or None
            The next one unless given.
        with_margins : bool
            Measure margins of the loop too, where they are limited; always for a real run.
        """
        run, metrics = self._measured(run, source)
        if with_margins or source == "IS1":
            metrics |= self.margins.at(gains)
        status, seconds = (
            (run.status, run.seconds) if isinstance(run, Trajectory) else ("ok", run.duration)
        )
        started = datetime.now(UTC) - timedelta(seconds=seconds)
        trial = Trial(
            number=self.next_number if number is None else number,
            source=source,
            gains=dict(gains),
            recording=run,
            objective=np.nan,
            metrics=metrics,
            status=status,
            started=run.start_time or started.isoformat(timespec="milliseconds"),
            seconds=seconds,
            seed=self.study.seed,
            twin=twin,
            parent=parent,
            late_error=self.experiment.late_error(run) if self.ranked else None,
        )
        return self.priced(trial) if self.normalised else trial

    def _measured(self, run: Recording, source: SourceName) -> tuple[Recording, dict[str, float]]:
        """A run with its metrics; a twin's run that the user's own function refuses has failed."""
        try:
            return run, self.experiment.metrics(run)
        except OwnMetricsError as refused:
            if source == "IS1":
                raise
            failed = ended_by(run, "failed", str(refused))
            return failed, self.experiment.metrics(failed)

    def priced(self, trial: Trial) -> Trial:
        """A trial with its cost, once the initial twin runs are done; always finite."""
        metrics = {name: self._finite(name, value) for name, value in trial.metrics.items()}
        return replace(trial, metrics=metrics, objective=float(self.objective.value(metrics)))

    def _finite(self, name: str, value: float) -> float:
        """A metric whose worst case is known: an infinite one becomes that.

        A metric of one reference, `NAME[2]`, is treated as the metric. NaN stays: it was not
        measured, and counts as the mean.
        """
        if not np.isinf(value):
            return value
        return self.objective.worst.get(name.partition("[")[0], np.nan)

    def write(self, trial: Trial) -> Trial:
        """Write a trial to disk, and only then add it to the history."""
        self.store.write_trial(trial)
        self.trials.append(trial)
        return trial

    def state(self, fixed: Mapping[str, float]) -> TuningState:
        """State from which a method proposes.

        Parameters
        ----------
        fixed : mapping of str to float
            Gains to be held at a value in the proposal.
        """
        seen = aged(self.observations(), self.drifts)
        return TuningState(
            space=self.gains.space,
            observations=by_rank(seen) if self.ranked else seen,
            fixed=fixed,
            trials=tuple(trial for trial in self.trials if self.is_current(trial)),
            experiment=self.experiment,
            objective=self.objective,
            limits=self.limits,
            keep_out=self.keep_out(),
            ranked=self.ranked,
        )

    def keep_out(self) -> KeepOut:
        """Gains that a real run is kept away from."""
        twin = [trial for trial in self.of("IS2", "IS3") if self.is_current(trial)]
        return self.caution.keep_out(self.of("IS1"), twin)

    def observations(self) -> tuple[Observation, ...]:
        """All runs as the surrogate sees them, in order.

        Rejected draws of IS3, and runs of twins that have been corrected since, are left out.
        """
        for trial in self.trials[self._seen :]:
            self._seen += 1
            if trial.accepted is not False:
                self._observations.append((trial, self._observed(trial)))
        return tuple(seen for trial, seen in self._observations if self.is_current(trial))

    def _observed(self, trial: Trial) -> Observation:
        point = self.unit_point(trial.gains)
        return observed(trial, point, self.experiment, self.objective, self.limits)
