"""The requested run as files in the study's folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gmfbo.errors import StoreError
from gmfbo.files.durable import cause, write_whole
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.writing.writer import write_recording
from gmfbo.tuning.query.request import TrialRequest

NEXT = "next.json"
PARALLEL = "next"
"""Folder of the files of runs that were asked for at once."""


def reference_files(count: int, trial: int | None = None) -> list[str]:
    """Names of the files to play, relative to the study's folder.

    Parameters
    ----------
    count : int
        Number of references.
    trial : int or None
        Of several runs asked for at once; None for a single one.

    Returns
    -------
    list of str
        `next.csv`, or `next1.csv`, `next2.csv` ... of several references; with a trial
        `next/5.csv`, or `next/5-1.csv`, `next/5-2.csv` ...
    """
    stem, joint = ("next", "") if trial is None else (f"{PARALLEL}/{trial}", "-")
    if count == 1:
        return [f"{stem}.csv"]
    return [f"{stem}{joint}{number + 1}.csv" for number in range(count)]


def next_run(request: TrialRequest, count: int, *, parallel: bool = False) -> dict[str, object]:
    """A requested run for JSON: its trial, all gains, the files to play and the note beside it.

    Parameters
    ----------
    request : TrialRequest
        The run.
    count : int
        Number of references.
    parallel : bool
        Whether it was asked for beside others.
    """
    names = reference_files(count, request.number if parallel else None)
    return {
        "trial": request.number,
        "gains": dict(request.gains),
        "references": names,
        "note": request.note,
    }


def write_next_run(
    folder: Path,
    request: TrialRequest,
    references: Sequence[Recording],
    *,
    parallel: bool = False,
) -> Path:
    """Write the requested run as JSON, and the references to play with the gains in their heads.

    Parameters
    ----------
    folder : Path
        Of the study.
    request : TrialRequest
        The run.
    references : sequence of Recording
        What to play.
    parallel : bool
        Whether it was asked for beside others; its files then lie in `next/`.

    Returns
    -------
    Path
        `next.json` or `next/TRIAL.json`; files are replaced where they exist.

    Raises
    ------
    StoreError, RecordingError
        The folder cannot be written.
    """
    content = next_run(request, len(references), parallel=parallel)
    path = folder / (f"{PARALLEL}/{request.number}.json" if parallel else NEXT)
    try:
        path.parent.mkdir(exist_ok=True)
        names = reference_files(len(references), request.number if parallel else None)
        for name, reference in zip(names, references, strict=True):
            write_recording(replace(reference, parameters=dict(request.gains)), folder / name)
        write_whole(path, (json.dumps(content, indent=1) + "\n").encode())
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {cause(error)}") from error
    return path


def remove_next_run(folder: Path, count: int, trial: int | None = None) -> None:
    """Remove the files of a run that was told, so that nobody plays it again.

    Parameters
    ----------
    folder : Path
        Of the study.
    count : int
        Number of references.
    trial : int or None
        The run; its files of either kind are removed. None removes those of a single run.
    """
    single = folder / NEXT
    if trial is not None:
        (folder / PARALLEL / f"{trial}.json").unlink(missing_ok=True)
        for name in reference_files(count, trial):
            (folder / name).unlink(missing_ok=True)
        if single.exists() and json.loads(single.read_text(encoding="utf-8"))["trial"] != trial:
            return
    for name in (NEXT, *reference_files(count)):
        (folder / name).unlink(missing_ok=True)
