"""A folder of recordings that were made before a study began, as real runs of it."""

from __future__ import annotations

from pathlib import Path

from gmfbo.errors import InputError, StudyFileError
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study_file.gain_choice import GainChoice
from gmfbo.tuning.told.contradiction import refuse_other_reference
from gmfbo.tuning.told.earlier_fit import cut_to, why_not
from gmfbo.tuning.told.told_file import ToldRun

NOTES = (".toml", ".md", ".json", ".txt")
"""Endings of files beside recordings that are none."""


def recordings_in(folder: Path) -> list[Path]:
    """Files of a folder that should be recordings, in the order of their names.

    Parameters
    ----------
    folder : Path
        The folder.
    """
    files = sorted(path for path in folder.iterdir() if path.is_file() and path.name[0] not in "._")
    return [path for path in files if path.suffix.lower() not in NOTES]


def choose_recordings(
    label: str,
    folder: Path,
    gains: GainChoice,
    experiment: ExperimentSeries,
    reading: SignalReading | None,
) -> tuple[list[str], dict[str, int]]:
    """File names that a study takes over, and the number of others by reason.

    Parameters
    ----------
    label : str
        The key of the study file, for messages.
    folder : Path
        Recordings with their gains as `# NAME = VALUE` lines.
    gains : GainChoice
        Tuned and held gains.
    experiment : ExperimentSeries
        With a single reference.
    reading : SignalReading or None
        Meaning of the columns.

    Raises
    ------
    StudyFileError
        The study has several references.
    """
    if len(experiment.parts) > 1:
        raise StudyFileError(
            f"{label}: a file holds one run, and this study plays {len(experiment.parts)} "
            "references a query; name an earlier study instead"
        )
    taken: list[str] = []
    left: dict[str, int] = {}
    for path in recordings_in(folder):
        try:
            why = _why_not(path, gains, experiment, reading)
        except InputError as error:
            why = str(error).removesuffix("; record again, or take it as it is (--anyway)")
        if why:
            left[why] = left.get(why, 0) + 1
        else:
            taken.append(path.name)
    return taken, left


def read_run(
    path: Path, gains: GainChoice, experiment: ExperimentSeries, reading: SignalReading | None
) -> Trial:
    """A chosen recording as a real run, cut to the length of this study.

    Parameters
    ----------
    path : Path
        The file.
    gains : GainChoice
        Tuned and held gains.
    experiment : ExperimentSeries
        With a single reference.
    reading : SignalReading or None
        Meaning of the columns.

    Raises
    ------
    RecordingError
        It cannot be read any more.
    """
    run = _read(path, experiment, reading)
    values = {name: run.parameters[name] for name in (*gains.space.names, *gains.fixed)}
    whole = cut_to(run, experiment, experiment)
    return Trial(0, "IS1", values, whole, float("nan"), {}, seconds=run.duration)


def _read(path: Path, experiment: ExperimentSeries, reading: SignalReading | None) -> Recording:
    return ToldRun.read(path, reading, experiment.reference).recording


def _why_not(
    path: Path, gains: GainChoice, experiment: ExperimentSeries, reading: SignalReading | None
) -> str:
    run = _read(path, experiment, reading)
    # The lines of a recording may state anything, such as a serial number.
    stated = {n: v for n, v in run.parameters.items() if n in (*gains.space.names, *gains.fixed)}
    if why := why_not(stated, stated, gains):
        return why
    part = experiment.parts[0]
    refuse_other_reference(part.reference, run, part.terms.band)
    experiment.metrics(run)
    return ""
