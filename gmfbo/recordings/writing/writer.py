"""Write a recording; the ending of the file name gives the format."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gmfbo.errors import RecordingError
from gmfbo.files.durable import cause, write_whole
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.writing.csv_text import is_ours
from gmfbo.version import __version__


def write_recording(recording: Recording, path: str | Path) -> Path:
    """Write a recording so that `read_recording` gives the same numbers, bit by bit.

    Parameters
    ----------
    recording : Recording
        Signals in SI; a Trajectory keeps its status.
    path : str or Path
        `.csv`, or `.h5` for the layout of a trial; replaced where it exists.

    Returns
    -------
    Path
        The file, written whole or not at all.

    Raises
    ------
    RecordingError
        The ending is another, a name cannot be written, or the folder cannot be written to.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in (".csv", ".h5", ".hdf5"):
        raise RecordingError(
            f"{path}: expected a file name that ends in .csv or .h5, got '{path.suffix}'"
        )
    try:
        if ending == ".csv":
            from gmfbo.recordings.writing.csv_text import csv_text

            content = csv_text(recording, __version__).encode()
        else:
            from gmfbo.recordings.writing.hdf5_group import (
                file_image,
                recording_content,
                write_content,
            )

            if is_ours(recording):
                recording = replace(recording, written_by=__version__)
            written = recording_content(recording)
            content = file_image(lambda root: write_content(root, written))
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error
    try:
        write_whole(path, content)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {cause(error)}") from error
    return path
