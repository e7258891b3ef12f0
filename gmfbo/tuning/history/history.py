"""History of a study: its runs, written to disk before they count, and derived values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import OwnMetricsError, SimulationError
from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.objective.metric_units import units_of_metrics
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.store.trial import SourceName, Trial
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.joined_runs import ended_by
from gmfbo.tuning.experiment.loop_margins import MarginMeter
from gmfbo.tuning.history.constants import objective_of
from gmfbo.tuning.history.incumbent import best_run
from gmfbo.tuning.history.keep_out import KeepOut
from gmfbo.tuning.history.known_margins import KnownMargins
from gmfbo.tuning.history.query_cost import IS1_COST, TWIN_COST
from gmfbo.tuning.history.standing import StandingStore, real_runs_at_ask
from gmfbo.tuning.history.state import Observation, TuningState
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
    ) -> None:
        self.store, self.study, self.experiment, self.gains = store, study, experiment, gains
        self.survey, self.earlier = survey, earlier
        self.margins = KnownMargins(meter, store)
        self.limits, self.envelope = Limits(study.constraints), study.safety.envelope
        self.trials: list[Trial] = store.trials()
        self.waiting: dict[int, Mapping[str, float]] = {}
        self.twin: str | None = None
        events = store.events()
        self.drifts = [Drift.logged(event) for event in events if event["event"] == "drift"]
        self.real_at_ask = real_runs_at_ask(events, self.of("IS1"))
        self._observations: list[tuple[Trial, Observation]] = []
        self._seen = 0
        self._leaves: dict[int, bool] = {}
        self._objective: Objective | None = None
        if len(self.of("IS2")) >= study.budget.initial_is2:
            self.normalise(self.of("IS2")[: study.budget.initial_is2])

    def of(self, *sources: SourceName) -> list[Trial]:
        """Trials of some sources, in order."""
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
    def cost(self) -> float:
        """Cost of all runs so far, in units of a real run."""
        return IS1_COST * self.made + TWIN_COST * len(self.of("IS2", "IS3"))

    @property
    def best(self) -> Trial | None:
        """Real run with the least cost since the plant changed, if possible within the limits."""
        return best_run(self.trials, self.limits, self.changed_after)

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
        if all(trial.status != "ok" for trial in initial):
            first = initial[0].recording
            reason = first.message if isinstance(first, Trajectory) else ""
            raise SimulationError(
                f"none of the {len(initial)} initial runs of IS2 succeeded "
                f"({initial[0].status}: {reason}); run the twin alone with 'gmfbo simulate'"
            )
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

    def taken_over(self, trial: Trial) -> Trial:
        """A real run of an earlier study as the next trial of this one, with this one's cost."""
        judged = self.envelope.judge(trial.recording)
        taken = self.trial("IS1", trial.gains, judged, twin=trial.twin)
        return replace(taken, started=trial.started, seconds=trial.seconds)

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
        return TuningState(
            space=self.gains.space,
            observations=self._aged(self.observations()),
            fixed=fixed,
            trials=tuple(trial for trial in self.trials if self.is_current(trial)),
            experiment=self.experiment,
            objective=self.objective,
            limits=self.limits,
            keep_out=self.keep_out(),
        )

    def _aged(self, observations: tuple[Observation, ...]) -> tuple[Observation, ...]:
        """Mark observations by the axis, or corrected by it, from before the plant changed.

        A run before several changes is marked with the sum of them.
        """
        if not self.drifts:
            return observations
        aged = []
        for seen in observations:
            origin = seen.number if seen.source == "IS1" else seen.parent
            shares = [
                drift.share
                for drift in self.drifts
                if seen.source != "IS2" and origin is not None and origin <= drift.last_before
            ]
            aged.append(replace(seen, outdated=sum(shares)) if shares else seen)
        return tuple(aged)

    def keep_out(self) -> KeepOut:
        """Gains that a real run is kept away from."""
        if not self.envelope:
            return KeepOut()
        safe, unsafe = [], []
        for trial in self.trials:
            if trial.source == "IS1" and trial.status != "unsafe":
                # A run that broke down shows neither safety nor danger.
                if trial.status == "ok":
                    safe.append(self.unit_point(trial.gains))
            elif trial.source == "IS1" or (self.is_current(trial) and self._twin_leaves(trial)):
                unsafe.append(self.unit_point(trial.gains))
        width = len(self.gains.space)
        return KeepOut(np.reshape(unsafe, (-1, width)), np.reshape(safe, (-1, width)))

    def _twin_leaves(self, trial: Trial) -> bool:
        """Whether the twin left the envelope, as far as it computes the signals."""
        if trial.number not in self._leaves:
            left = self.envelope.first_exit(trial.recording, all_signals=False)
            self._leaves[trial.number] = left is not None
        return self._leaves[trial.number]

    def observations(self) -> tuple[Observation, ...]:
        """All runs as the surrogate sees them, in order.

        Rejected draws of IS3, and runs of twins that have been corrected since, are left out.
        """
        for trial in self.trials[self._seen :]:
            self._seen += 1
            if trial.accepted is not False:
                self._observations.append((trial, self._observation(trial)))
        return tuple(seen for trial, seen in self._observations if self.is_current(trial))

    def _observation(self, trial: Trial) -> Observation:
        uncorrected = uncorrected_scaled = None
        if trial.source == "IS3":
            before = trial.uncorrected[self.experiment.signal]
            metrics = self.experiment.metrics_of(trial.recording.time, before)
            uncorrected = float(self.objective.value(metrics))
            uncorrected_scaled = float(self.objective.scaled(metrics))
        return Observation(
            number=trial.number,
            source=trial.source,
            point=self.unit_point(trial.gains),
            objective=trial.objective,
            scaled=float(self.objective.scaled(trial.metrics)),
            failed=trial.status != "ok",
            parent=trial.parent,
            uncorrected=uncorrected,
            uncorrected_scaled=uncorrected_scaled,
            limited={n: float(v) for n, v in self.limits.limited(trial.metrics).items()},
            feasible=trial.status == "ok" and self.limits.met(trial.metrics),
        )
