"""The run that is wanted, as files in the study's folder for whoever makes it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from gmfbo.errors import StoreError
from gmfbo.recordings.durable import cause, write_whole
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.writer import write_recording
from gmfbo.tuning.request import TrialRequest

NEXT, REFERENCE = "next.json", "next.csv"


def next_run_text(request: TrialRequest) -> str:
    """JSON of a wanted run: its trial, gains in full and the file to play."""
    content = {"trial": request.number, "gains": dict(request.gains), "reference": REFERENCE}
    return json.dumps(content, indent=1)


def write_next_run(folder: Path, request: TrialRequest, reference: Recording) -> Path:
    """Write `next.json` and `next.csv`, the reference to play with the gains in its head.

    Parameters
    ----------
    folder : Path
        Of the study.
    request : TrialRequest
        What is wanted.
    reference : Recording
        What the axis shall follow.

    Returns
    -------
    Path
        `next.json`; both are replaced where they exist.

    Raises
    ------
    StoreError, RecordingError
        The folder cannot be written.
    """
    write_recording(replace(reference, parameters=dict(request.gains)), folder / REFERENCE)
    path = folder / NEXT
    try:
        write_whole(path, (next_run_text(request) + "\n").encode())
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {cause(error)}") from error
    return path


def remove_next_run(folder: Path) -> None:
    """Remove both: nobody shall play what was told already."""
    for name in (NEXT, REFERENCE):
        (folder / name).unlink(missing_ok=True)
