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


def reference_files(count: int) -> list[str]:
    """Names of the files to play: `next.csv`, or `next1.csv`, `next2.csv` ... of several."""
    return ["next.csv"] if count == 1 else [f"next{number + 1}.csv" for number in range(count)]


def next_run_text(request: TrialRequest, count: int) -> str:
    """JSON of a requested run: its trial, all gains and the files to play."""
    names = reference_files(count)
    content = {"trial": request.number, "gains": dict(request.gains), "references": names}
    return json.dumps(content, indent=1)


def write_next_run(folder: Path, request: TrialRequest, references: Sequence[Recording]) -> Path:
    """Write `next.json`, and the references to play with the gains in their heads.

    Returns
    -------
    Path
        `next.json`; files are replaced where they exist.

    Raises
    ------
    StoreError, RecordingError
        The folder cannot be written.
    """
    for name, reference in zip(reference_files(len(references)), references, strict=True):
        write_recording(replace(reference, parameters=dict(request.gains)), folder / name)
    path = folder / NEXT
    try:
        write_whole(path, (next_run_text(request, len(references)) + "\n").encode())
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {cause(error)}") from error
    return path


def remove_next_run(folder: Path, count: int) -> None:
    """Remove these files, so that nobody plays a run that was told already."""
    for name in (NEXT, *reference_files(count)):
        (folder / name).unlink(missing_ok=True)
