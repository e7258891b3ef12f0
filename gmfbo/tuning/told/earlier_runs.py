"""Real runs made before a study that it takes over: of a study, a folder, or a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

from gmfbo.errors import InputError, StoreError, StudyFileError
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.query.left_out import reasons_told
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.earlier_fit import cut_to, refuse_other_experiment, why_not
from gmfbo.tuning.told.earlier_recordings import choose_recordings, read_run
from gmfbo.tuning.told.earlier_table import STUDIES, EarlierTable, TableTerms, taken_row

if TYPE_CHECKING:
    from gmfbo.recordings.columns.signal import SignalReading
    from gmfbo.tuning.history.history import History
    from gmfbo.tuning.history.standing import StandingStore

_OF_A_STUDY = ("study.toml", "events.jsonl")
"""Either file shows that a folder is a study."""


@dataclass(frozen=True, eq=False)
class EarlierRuns:
    """Real runs that a study takes over before its own first query.

    The runs are copied, cut to the horizon of the new study and scored by its objective; rows of a
    table bring their metrics. The choice is logged before the first run is written, so that a study
    killed meanwhile takes the same runs.

    Attributes
    ----------
    gains : GainChoice
        Tuned and held gains of the new study.
    experiment : ExperimentSeries
        Its experiment.
    location : Path or None
        Folder of the earlier study, its packed file, a folder of recordings, or a table; None where
        the study file names none.
    numbers : tuple of int
        Numbers of the trials that are taken, in order; empty for recordings and tables.
    files : tuple of str
        Names of the recordings that are taken, in order.
    rows : tuple of int
        Rows of the table that are taken, from 1.
    reasons : mapping of str to int
        Why runs are not taken, and how many.
    reading : SignalReading or None
        Meaning of the columns of a recording.
    terms : TableTerms or None
        What is read in a table.
    """

    gains: GainChoice
    experiment: ExperimentSeries
    location: Path | None = None
    numbers: tuple[int, ...] = ()
    files: tuple[str, ...] = ()
    rows: tuple[int, ...] = ()
    reasons: Mapping[str, int] = field(default_factory=dict)
    reading: SignalReading | None = None
    terms: TableTerms | None = None

    @classmethod
    def find(
        cls, study: Study, gains: GainChoice, experiment: ExperimentSeries, sources: StudySources
    ) -> Self:
        """Choose the runs, or read the choice from the log of a begun study.

        Raises
        ------
        StudyFileError
            The earlier runs followed another reference, used another unit, or none can be taken.
        StoreError
            There is nothing at this place.
        """
        reading, units = sources.reading, sources.units_of(gains)
        terms = TableTerms.of(study.file, gains, experiment, units)
        nothing = cls(gains, experiment, reading=reading, terms=terms)
        if study.file.earlier is None:
            return nothing
        path, label = study.origin / study.file.earlier, f"earlier = '{study.file.earlier}'"
        logged = study.earlier_logged
        if logged is not None:
            # Former versions logged no reasons.
            reasons = logged.get("reasons", {"not within [gains]": logged["left_out"]})
            files, rows = tuple(logged.get("files", ())), tuple(logged.get("rows", ()))
            numbers = () if files or rows else tuple(logged["trials"])
            begun = replace(nothing, location=path, reasons=reasons)
            return replace(begun, numbers=numbers, files=files, rows=rows)
        if path.is_dir() and not any((path / name).exists() for name in _OF_A_STUDY):
            names, reasons = choose_recordings(label, path, gains, experiment, reading)
            return replace(nothing, location=path, files=tuple(names), reasons=reasons)._any(label)
        if path.is_file() and path.suffix.lower() not in STUDIES:
            return replace(nothing, location=path)._of_table(label, terms)._any(label)
        return nothing._of_study(label, Study.read(path), study)._any(label)

    def __len__(self) -> int:
        return len(self.numbers or self.files or self.rows)

    @property
    def left_out(self) -> int:
        """Number of real runs that are not taken."""
        return sum(self.reasons.values())

    @property
    def why_left_out(self) -> tuple[str, ...]:
        """Reasons with their numbers, one a line."""
        return reasons_told(self.reasons)

    def log_once(self, study: Study, store: StandingStore) -> None:
        """Log the choice before its first run is written.

        Parameters
        ----------
        study : Study
            The new study.
        store : StandingStore
            Its store.
        """
        if len(self) and study.earlier_logged is None:
            others = {"files": list(self.files), "rows": list(self.rows)}
            store.log(
                "earlier",
                study=str(self.location),
                trials=list(self.numbers or range(1, len(self) + 1)),
                left_out=self.left_out,
                reasons=dict(self.reasons),
                **{name: chosen for name, chosen in others.items() if chosen},
            )

    def take(self, position: int, history: History) -> Trial:
        """One of the runs as the next trial of this study, with its cost; it is not yet on disk.

        Parameters
        ----------
        position : int
            0, 1, 2 ... in the order in which they are taken.
        history : History
            Of this study, with the initial runs of the twin.

        Raises
        ------
        StoreError
            The run no longer exists.
        """
        run = self.read(position)
        if run.bare:
            return taken_row(run, history)
        judged = history.envelope.judge(run.recording)
        taken = history.trial("IS1", run.gains, judged, twin=run.twin)
        return replace(taken, started=run.started, seconds=run.seconds)

    def read(self, position: int) -> Trial:
        """Read one of the runs, with the gains and the length that this study has.

        Parameters
        ----------
        position : int
            0, 1, 2 ... in the order in which they are taken.

        Raises
        ------
        StoreError
            The run no longer exists.
        """
        assert self.location is not None
        if self.files:
            path = self.location / self.files[position]
            if not path.is_file():
                raise StoreError(f"{path}: is not there any more{_BEGUN}")
            return read_run(path, self.gains, self.experiment, self.reading)
        if self.rows:
            return self._table.trial(self.rows[position])
        return self._trial(self.numbers[position])

    def _trial(self, number: int) -> Trial:
        from gmfbo.recordings.store.study_folder import StudyStore

        assert self.location is not None
        earlier = Study.read(self.location)
        with StudyStore.open(earlier.location) as store:
            if number not in store.numbers():
                raise StoreError(
                    f"{earlier.location}: trial {number} is not there any more{_BEGUN}"
                )
            trial = store.read_trial(number)
        played = _played(earlier, self.experiment)
        known = _known(trial)
        wanted = (*self.gains.space.names, *self.gains.fixed)
        return replace(
            trial,
            gains={name: known[name] for name in wanted},
            recording=cut_to(trial.recording, played, self.experiment),
        )

    @cached_property
    def _table(self) -> EarlierTable:
        assert self.location is not None
        assert self.terms is not None
        if not self.location.is_file():
            raise StoreError(f"{self.location}: is not there any more{_BEGUN}")
        return EarlierTable.read(self.location.name, self.location, self.terms)

    def _of_table(self, label: str, terms: TableTerms) -> Self:
        assert self.location is not None
        if len(self.experiment.parts) > 1:
            raise StudyFileError(
                f"{label}: a row holds one value of each metric, and this study plays "
                f"{len(self.experiment.parts)} references a query; name an earlier study instead"
            )
        rows, reasons = EarlierTable.read(label, self.location, terms).chosen()
        return replace(self, rows=tuple(rows), reasons=reasons)

    def _of_study(self, label: str, earlier: Study, study: Study) -> Self:
        if earlier.location.resolve() == study.location.resolve():
            raise StudyFileError(f"{label}: is this study itself; name another one")
        try:
            refuse_other_experiment(label, _played(earlier, self.experiment), self.experiment)
        except InputError as error:
            raise StudyFileError(str(error)) from None
        taken, reasons = [], dict[str, int]()
        undone = earlier.taken_back
        for trial in earlier.trials:
            if trial.source != "IS1" or trial.number in undone:
                continue
            _check_signal(label, trial, self.experiment)
            if why := why_not(trial.gains, _known(trial), self.gains):
                reasons[why] = reasons.get(why, 0) + 1
            else:
                taken.append(trial.number)
        return replace(self, location=earlier.location, numbers=tuple(taken), reasons=reasons)

    def _any(self, label: str) -> Self:
        """Itself; raises where no run can be taken."""
        if len(self):
            return self
        why = f" ({'; '.join(self.why_left_out)})" if self.reasons else ""
        raise StudyFileError(
            f"{label}: expected real runs that this study could have asked for, {self.left_out} "
            f"were made, none of them is{why}; change [gains] or name another place"
        )


_BEGUN = ", but this study began to take it; bring it back, or give another 'out'"


def _played(earlier: Study, experiment: ExperimentSeries) -> ExperimentSeries:
    return ExperimentSeries.from_sections(
        earlier.file.references, experiment.signal, folder=earlier.origin
    )


def _known(trial: Trial) -> dict[str, float]:
    """Gains of a run, and further parameters that its recording states."""
    return {**trial.recording.parameters, **trial.gains}


def _check_signal(label: str, trial: Trial, experiment: ExperimentSeries) -> None:
    if trial.status != "ok":
        return  # the cost of a failed run does not depend on its signals
    name = experiment.signal
    if name not in trial.recording.signals:
        raise StudyFileError(
            f"{label}: expected the signal '{name}', its trial {trial.number} has "
            f"{', '.join(sorted(trial.recording.signals))}; see [objective] signal"
        )
    for part in experiment.parts:
        here = part.reference.units.get(part.reference_signal, "")
        there = trial.recording.units.get(name, "")
        if here and there and here != there:
            raise StudyFileError(
                f"{label}: expected '{name}' in {here}, its trial {trial.number} has it in "
                f"{there}; this is another axis"
            )
