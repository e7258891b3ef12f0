"""Real runs of an earlier study that a new one takes over."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from gmfbo.errors import StoreError, StudyFileError
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.told_gains import same_gain


@dataclass(frozen=True)
class EarlierRuns:
    """Real runs that a study takes over before its own first query.

    The runs are copied, and scored by the objective of the new study. The choice is logged
    before the first run is written, so that a study killed meanwhile takes the same runs.

    Attributes
    ----------
    location : Path or None
        Folder of the earlier study, or its packed file; None where the study file names none.
    numbers : tuple of int
        Numbers of its trials that are taken, in order.
    left_out : int
        Number of its real runs at gains that this study could not ask for.
    """

    location: Path | None = None
    numbers: tuple[int, ...] = ()
    left_out: int = 0

    @classmethod
    def find(cls, study: Study, gains: GainChoice, experiment: ExperimentSeries) -> Self:
        """Choose the runs, or read the choice from the log of a begun study.

        Raises
        ------
        StudyFileError
            The earlier study tuned other gains, played another reference, used another unit, or
            has no run that can be taken.
        StoreError
            There is no earlier study at this place.
        """
        if study.file.earlier is None:
            return cls()
        path = study.origin / study.file.earlier
        logged = study.earlier_logged
        if logged is not None:
            return cls(path, tuple(logged["trials"]), logged["left_out"])
        earlier = Study.read(path)
        label = f"earlier = '{study.file.earlier}'"
        if earlier.location.resolve() == study.location.resolve():
            raise StudyFileError(f"{label}: is this study itself; name another one")
        _check_reference(label, earlier, experiment)
        undone = earlier.taken_back
        counted = [trial for trial in earlier.trials if trial.number not in undone]
        real = [trial for trial in counted if trial.source == "IS1"]
        for trial in real:
            _check_names(label, trial, gains)
            _check_signal(label, trial, experiment)
        taken = tuple(trial.number for trial in real if _within(trial, gains))
        if not taken:
            raise StudyFileError(
                f"{label}: expected real runs within [gains], {len(real)} were made, none there; "
                "widen [gains] or name another study"
            )
        return cls(earlier.location, taken, len(real) - len(taken))

    def __len__(self) -> int:
        return len(self.numbers)

    def read(self, position: int) -> Trial:
        """Read one of the runs from the earlier study.

        Parameters
        ----------
        position : int
            0, 1, 2 ... in the order in which they are taken.

        Raises
        ------
        StoreError
            The run no longer exists.
        """
        from gmfbo.recordings.store.study_folder import StudyStore

        assert self.location is not None
        folder = Study.read(self.location).location
        with StudyStore.open(folder) as store:
            if self.numbers[position] not in store.numbers():
                raise StoreError(
                    f"{folder}: trial {self.numbers[position]} is not there any more, but this "
                    "study began to take it; bring it back, or give another 'out'"
                )
            return store.read_trial(self.numbers[position])

    @property
    def event(self) -> dict[str, Any]:
        """Log entry of the choice."""
        return {
            "study": str(self.location),
            "trials": list(self.numbers),
            "left_out": self.left_out,
        }


def _check_reference(label: str, earlier: Study, experiment: ExperimentSeries) -> None:
    played = ExperimentSeries.from_sections(
        earlier.file.references, experiment.signal, folder=earlier.origin
    )
    same = len(played.parts) == len(experiment.parts) and all(
        np.array_equal(one.reference.time, other.reference.time)
        and one.reference.signals.keys() == other.reference.signals.keys()
        and all(
            np.array_equal(values, other.reference.signals[name])
            for name, values in one.reference.signals.items()
        )
        and one.horizon == other.horizon
        for one, other in zip(played.parts, experiment.parts, strict=True)
    )
    if not same:
        raise StudyFileError(
            f"{label}: expected the same [reference] as here ({_steps(experiment)}), it played "
            f"{_steps(played)}; runs of another one cannot be compared"
        )


def _steps(experiment: ExperimentSeries) -> str:
    return ", ".join(
        f"{part.described}, scored for {part.horizon:g} s" for part in experiment.parts
    )


def _check_names(label: str, trial: Trial, gains: GainChoice) -> None:
    wanted = {*gains.space.names, *gains.fixed}
    if set(trial.gains) != wanted:
        raise StudyFileError(
            f"{label}: expected the gains {', '.join(sorted(wanted))}, its trial {trial.number} "
            f"has {', '.join(sorted(trial.gains))}; name the same ones in [gains], a number holds "
            "one"
        )


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


def _within(trial: Trial, gains: GainChoice) -> bool:
    """Whether this study could have asked for the run."""
    if not all(same_gain(trial.gains[name], value) for name, value in gains.fixed.items()):
        return False
    return all(gain.low <= trial.gains[gain.name] <= gain.high for gain in gains.space.gains)
