"""Review of a study: its runs and derived values, for page and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import StoreError
from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.objective.metric_units import metric_unit
from gmfbo.objective.metric_words import MetricWords
from gmfbo.objective.metrics import worst_metrics
from gmfbo.pages.marked_number import unit_text
from gmfbo.recordings.store.trial import Trial
from gmfbo.reports.study.descent import Descent
from gmfbo.reports.study.run_roles import Run, placed_runs
from gmfbo.space import Gain, GainSpace
from gmfbo.tuning.history.incumbent import best_run, has_settled
from gmfbo.tuning.history.standing import END, in_order, standing_events, undone_numbers
from gmfbo.tuning.study_file.study_file import as_begun, parse_study
from gmfbo.tuning.study_file.study_sections import StudyFile
from gmfbo.tuning.twin.learned import learned_lines

if TYPE_CHECKING:
    from gmfbo.tuning.drift.drift import Drift

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TwinVersion:
    """A twin that replaced another.

    Attributes
    ----------
    version : str
        Its name or number.
    reason : str
        Reason of the change.
    after : int
        Trial number of the real run that led to it.
    learned : tuple of str
        What it has learned, in lines.
    """

    version: str
    reason: str
    after: int
    learned: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class StudyReview:
    """A study as it is shown.

    Attributes
    ----------
    file : StudyFile
        The validated study file.
    location : Path
        Folder or file that it was read from.
    runs : tuple of Run
        In order.
    events : tuple of mapping
        Of its log, those that still count.
    taken_back : tuple of Trial
        Runs on disk that count no more.
    """

    file: StudyFile
    location: Path
    runs: tuple[Run, ...]
    events: tuple[Mapping[str, Any], ...]
    taken_back: tuple[Trial, ...] = ()

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a study's folder or a packed study, also while it runs.

        Parameters
        ----------
        path : str or Path
            `NAME.study/` or a packed `.h5`.

        Raises
        ------
        StoreError
            There is no study, or no run in it yet.
        StudyFileError
            Its study file cannot be used.
        """
        from gmfbo.recordings.store.study_folder import StudyStore

        path = Path(path)
        with StudyStore.open(path) as store:
            name = path.name.removesuffix(path.suffix)
            file = parse_study(store.study_text, label=f"{path}: study.toml", default_name=name)
            events, trials = store.events(), store.trials()
        if not trials:
            begin = "gmfbo ask" if file.is1.ask_tell else "gmfbo tune"
            raise StoreError(
                f"{path}: expected a study with runs, but there is none yet; wait for its first "
                f"runs, or begin with '{begin}'"
            )
        return cls.placed(file, path, trials, events)

    @classmethod
    def placed(
        cls,
        file: StudyFile,
        location: Path,
        trials: Sequence[Trial],
        events: Sequence[dict[str, Any]],
    ) -> Self:
        """Review runs and log of a study; what was taken back is set apart.

        Parameters
        ----------
        file : StudyFile
            The validated study file.
        location : Path
            Folder or file that it was read from.
        trials : sequence of Trial
            In the order of their numbers.
        events : sequence of dict
            Of its log.
        """
        undone = undone_numbers(events)
        standing = standing_events(events, {trial.number for trial in trials})
        counted = in_order([trial for trial in trials if trial.number not in undone], standing)
        return cls(
            as_begun(file, events),
            location,
            placed_runs(counted, standing, file.budget),
            tuple(standing),
            tuple(trial for trial in trials if trial.number in undone),
        )

    @cached_property
    def trials(self) -> Mapping[int, Trial]:
        """Each trial by its number."""
        return {run.trial.number: run.trial for run in self.runs}

    @cached_property
    def real(self) -> tuple[Run, ...]:
        """Real runs in order, those of an earlier study included."""
        return self.of("IS1")

    def signal_unit(self, signal: str) -> str:
        """Unit of a signal of the real runs, as an FMU spells it; empty where none has one.

        Parameters
        ----------
        signal : str
            Its name.
        """
        units = (run.trial.recording.units.get(signal, "") for run in self.real)
        return next(filter(None, units), "")

    def of(self, source: str) -> tuple[Run, ...]:
        """Runs of one source, in order.

        Parameters
        ----------
        source : {"IS1", "IS2", "IS3"}
            Source of the runs.
        """
        return tuple(run for run in self.runs if run.trial.source == source)

    @cached_property
    def limits(self) -> Limits:
        """On metrics."""
        return Limits(self.file.constraints)

    @cached_property
    def best(self) -> Trial | None:
        """Best real run; None while none succeeded."""
        return self._best(len(self.real))

    @property
    def settled(self) -> bool:
        """Whether a real run settled, or the study does not ask for it."""
        return any(has_settled(run.trial) for run in self.real) or all(
            run.trial.late_error is None for run in self.real
        )

    @property
    def best_words(self) -> str:
        """What the best real run is called: where none settled, it is only the least bad."""
        return "best" if self.settled else "least bad"

    @property
    def first(self) -> Trial | None:
        """First real run that succeeded, with which the best is compared."""
        return next((run.trial for run in self.real if run.trial.status == "ok"), None)

    @cached_property
    def descent(self) -> Descent:
        """Progress of the best real run."""
        best = [self._best(count) for count in range(1, len(self.real) + 1)]
        return Descent(
            numbers=tuple(run.trial.number for run in self.real),
            cost=np.array([run.cost for run in self.real]),
            objective=np.array([run.trial.objective for run in self.real]),
            best=np.array([np.nan if one is None else one.objective for one in best]),
        )

    def _best(self, count: int) -> Trial | None:
        """Best of the first real runs, by the changes of the plant known then."""
        found = [drift for drift in self.drifts if drift.found_at <= count]
        since = found[-1].last_before if found else 0
        return best_run((run.trial for run in self.real[:count]), self.limits, since)

    @cached_property
    def box(self) -> GainSpace:
        """Tuned gains whose range is known: as the study logged it, else by its file."""
        begun = self.logged("begin")
        logged = begun[-1].get("box", ()) if begun else ()
        if logged:
            return GainSpace(tuple(Gain(**{**g, "values": tuple(g["values"])}) for g in logged))
        given = [section.gain(name) for name, section in self.file.gains.items()]
        return GainSpace(tuple(gain for gain in given if isinstance(gain, Gain)))

    @cached_property
    def space(self) -> GainSpace:
        """Box of the tuned gains; where a range is not known, the range of the runs."""
        gains, known = [], {gain.name: gain for gain in self.box.gains}
        for name in self.runs[0].trial.gains:
            values = [run.trial.gains[name] for run in self.runs]
            if name in known:
                gains.append(known[name])
            elif name not in self.file.gains and min(values) < max(values):
                gains.append(Gain(name, min(values), max(values)))
        return GainSpace(tuple(gains))

    def gain_unit(self, name: str) -> str:
        """Unit of a gain, for reading; empty where its FMU has none, or none was logged.

        Parameters
        ----------
        name : str
            Of the gain.
        """
        begun = self.logged("begin")
        return unit_text(str(begun[-1].get("units", {}).get(name, ""))) if begun else ""

    def points(self, runs: Sequence[Run]) -> Array:
        """Gains of runs in the unit cube, shape (n, d).

        Parameters
        ----------
        runs : sequence of Run
            Of any source.
        """
        moved = [[run.trial.gains[name] for name in self.space.names] for run in runs]
        return self.space.to_unit(np.reshape(moved, (-1, len(self.space))))

    @cached_property
    def drifts(self) -> tuple[Drift, ...]:
        """Changes of the plant that were found, in order."""
        logged = self.logged("drift")
        if not logged:
            return ()  # most studies: saves the import of the detector
        from gmfbo.tuning.drift.drift import Drift

        return tuple(Drift.logged(dict(event)) for event in logged)

    @cached_property
    def mismatch(self) -> tuple[tuple[int, float], ...]:
        """Trial number of each query with a mismatch e, and e, dimensionless."""
        return tuple(
            (event["number"], float(event["mismatch"]))
            for event in self.logged("ask")
            if event["mismatch"] is not None and event["number"] in self.trials
        )

    @cached_property
    def correction(self) -> tuple[tuple[int, float, float], ...]:
        """By real run: RMS error of twin and corrected twin, held out [unit of the signal]."""
        return tuple(
            (event["parent"], float(event["uncorrected_error"]), float(event["held_out_error"]))
            for event in self.logged("correction")
            if event["parent"] in self.trials
        )

    @cached_property
    def twin_versions(self) -> tuple[TwinVersion, ...]:
        """Twins that replaced another during the study, in order."""
        return tuple(
            TwinVersion(
                str(event["version"]), str(event["reason"]), event["after"], learned_lines(event)
            )
            for event in self.logged("twin_version")
        )

    @cached_property
    def twin_runs(self) -> tuple[Run, ...]:
        """Runs of the present twin, since earlier twins have other costs."""
        versions = self.logged("twin_version")
        now = versions[-1]["twin"] if versions else None
        return tuple(run for run in self.of("IS2") if now is None or run.trial.twin == now)

    def twin_beside(self, real: Trial) -> Trial | None:
        """The newest run of the twin at a real run's gains; None without one.

        Parameters
        ----------
        real : Trial
            A real run.
        """
        beside = [
            run.trial
            for run in self.of("IS2")
            if run.role == "beside" and run.trial.parent == real.number
        ]
        return beside[-1] if beside else None

    @property
    def recommendation(self) -> Mapping[str, Any] | None:
        """Gains that the surrogate recommended last, with mean and std of their cost."""
        logged = self.logged("recommendation")
        return logged[-1] if logged else None

    @property
    def ended(self) -> bool:
        """Whether the study ended, and was not continued since.

        Studies of former versions logged no end: there the recommendation stands for it.
        """
        ends, known = ("recommendation", END), [entry["event"] for entry in self.events]
        told = [event for event in known if event in ("ask", "tell", *ends)]
        return bool(told) and told[-1] in ends

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of all metrics, those of the cost first."""
        known = list(dict.fromkeys([*self.file.objective.weights, *self.runs[0].trial.metrics]))
        return tuple(name for name in known if name in self.runs[0].trial.metrics)

    @cached_property
    def objective(self) -> Objective | None:
        """The cost with its constants; None where a study of a former version lacks them."""
        logged = self.logged("normalise")
        if not logged or "worst" not in logged[-1]:
            return None
        constants = logged[-1]
        weights = self.file.objective.weights
        return Objective(weights, constants["mean"], constants["std"], constants["worst"])

    @cached_property
    def metric_units(self) -> Mapping[str, str]:
        """Unit of each metric that depends on the signals, and of the user's own as stated."""
        logged = self.logged("normalise")
        units = logged[-1].get("units", {}) if logged else {}
        return {**units, **self.file.objective.units}

    @cached_property
    def metric_words(self) -> MetricWords:
        """Words for metrics."""
        # Studies of one reference and no metrics of the user's own did not log the worst case.
        known = self.objective
        worst = known.worst if known else worst_metrics(self.file.reference.horizon)
        horizons = [reference.horizon for reference in self.file.references]
        return MetricWords.of(self.metric_units, worst, horizons)

    def unit_of(self, metric: str) -> str:
        """Unit of a metric; empty for a user's own without a stated one.

        Parameters
        ----------
        metric : str
            As it is stored.
        """
        return metric_unit(metric, self.metric_units)

    def logged(self, event: str) -> list[Mapping[str, Any]]:
        """Events of one kind, in order.

        Parameters
        ----------
        event : str
            Kind, such as `ask` or `tell`.
        """
        return [entry for entry in self.events if entry["event"] == event]
