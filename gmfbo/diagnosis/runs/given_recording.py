"""Read a recording as the user gives it, and check its length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gmfbo.diagnosis.runs.scored_record import LEAST_ROWS
from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

MOST_ROWS = 1_000_000
"""Rows of one recording; each takes about 1.5 kB while its runs are compared."""


def as_recording(recording: Recording | str | Path, twin: FmuTwin) -> Recording:
    """Read a recording that is given as a file.

    Parameters
    ----------
    recording : Recording or str or Path
        The recording, or its file.
    twin : FmuTwin
        Its file tells the meaning of the columns.

    Raises
    ------
    RecordingError
        It cannot be read, or has too few rows to diagnose or too many for memory.
    """
    read = recording if isinstance(recording, Recording) else Recording.read(recording, twin)
    if len(read) < LEAST_ROWS:
        raise RecordingError(
            f"{read.name or 'recording'}: expected at least {LEAST_ROWS} rows to compare with the "
            f"twin, got {len(read)}; record longer"
        )
    if len(read) > MOST_ROWS:
        raise RecordingError(
            f"{read.name or 'recording'}: expected at most {MOST_ROWS} rows, got {len(read)}, "
            "which would take gigabytes of memory; cut out minutes in which the axis moves"
        )
    return read


def on_fmu_clock(
    recordings: Sequence[Recording], twin: FmuTwin
) -> tuple[list[Recording], dict[str, float]]:
    """Count time as the FMU does: laws that depend on time have their parameters in its time.

    Parameters
    ----------
    recordings : sequence of Recording
        By their own clocks.
    twin : FmuTwin
        Tells when its FMUs begin.

    Returns
    -------
    tuple of list of Recording and dict of str to float
        The recordings, and what is added to a time for the clock of the recording of a name [s].
    """
    moved, later = [], {}
    for recording in recordings:
        first = float(recording.time[0])
        start = twin.binding.start_time(first)
        if first != start:
            later[recording.name] = first - start
            use = recording.use and (
                recording.use[0] - first + start,
                recording.use[1] - first + start,
            )
            time = recording.time - first + start
            moved.append(replace(recording, time=time, use=use))
        else:
            moved.append(recording)
    return moved, later
