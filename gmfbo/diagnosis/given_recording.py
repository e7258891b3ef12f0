"""A recording as the user gives it: read, and long enough to tell anything."""

from __future__ import annotations

from pathlib import Path

from gmfbo.diagnosis.records import LEAST_ROWS
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin import FmuTwin


def as_recording(recording: Recording | str | Path, twin: FmuTwin) -> Recording:
    """Read a recording that is given as a file.

    Parameters
    ----------
    recording : Recording or str or Path
        The recording, or its file.
    twin : FmuTwin
        Says what the columns are.

    Raises
    ------
    RecordingError
        It cannot be read, or has fewer rows than say anything.
    """
    read = recording if isinstance(recording, Recording) else Recording.read(recording, twin)
    if len(read) < LEAST_ROWS:
        raise RecordingError(
            f"{read.name or 'recording'}: expected at least {LEAST_ROWS} rows to compare with the "
            f"twin, got {len(read)}; record longer"
        )
    return read
