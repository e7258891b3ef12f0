"""Recordings told for one query: one for each reference, in their order."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.told.contradiction import refuse_other_reference
from gmfbo.tuning.told.told_file import ToldRun

Told = Recording | str | Path


def read_told(
    told: Told | Sequence[Told],
    reading: SignalReading | None,
    experiment: ExperimentSeries,
    *,
    anyway: bool = False,
) -> ToldRun:
    """Read the recordings told for a query.

    Parameters
    ----------
    told : Recording, str, Path, or a sequence of them
        One for each reference, in order. A single `Recording` is the whole query.
    reading : SignalReading or None
        Meaning of a file's columns.
    experiment : ExperimentSeries
        References that were played.
    anyway : bool
        Take a file whose own reference is another than was asked for.

    Raises
    ------
    RecordingError
        A file cannot be read or follows another reference, or there are not as many as references.
    """
    if isinstance(told, Recording):
        return ToldRun(told)
    each = [told] if isinstance(told, str | Path) else list(told)
    if not each:
        raise RecordingError("expected a recording, got none")
    runs = [
        ToldRun.read(one, reading, reference)
        for one, reference in zip(each, experiment.references, strict=False)
    ]
    if not anyway:
        for run, part in zip(runs, experiment.parts, strict=False):
            refuse_other_reference(part.reference, run.recording, part.terms.band)
    if len(each) == len(experiment.references) == 1:
        return runs[0]
    # Joining refuses more recordings than references, and names both numbers.
    joined = experiment.join(
        [run.recording for run in runs] + [runs[-1].recording] * (len(each) - len(runs))
    )
    hashes = [run.sha256 for run in runs if run.sha256]
    whole = hashlib.sha256("".join(hashes).encode()).hexdigest() if hashes else ""
    return ToldRun(joined, ", ".join(run.file for run in runs if run.file), whole)
