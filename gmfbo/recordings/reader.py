"""Read a recording: the ending of the file name decides how."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.recordings.durable import cause
from gmfbo.recordings.interpretation import recording_from

if TYPE_CHECKING:
    from gmfbo.recordings.columns import RecordedColumns
    from gmfbo.recordings.recording import Recording
    from gmfbo.recordings.signal import SignalReading

# Module and function; loaded when used, as h5py and SciPy take their time.
_READERS = {
    ".csv": ("csv_file", "read_csv"),
    ".txt": ("csv_file", "read_csv"),
    ".h5": ("hdf5_file", "read_hdf5"),
    ".hdf5": ("hdf5_file", "read_hdf5"),
    ".mat": ("mat_file", "read_mat"),
}


def read_recording(path: str | Path, twin: SignalReading | None = None) -> Recording:
    """Read a recording from a file.

    Parameters
    ----------
    path : str or Path
        `.csv` (`.txt`), `.h5` (`.hdf5`) or `.mat`.
    twin : SignalReading or None
        Says which columns are signals, with scale, offset and unit, and which names are FMU
        parameters. Without it each column is a signal and each single value a parameter.

    Returns
    -------
    Recording
        In SI units, named after the file.

    Raises
    ------
    RecordingError
        The file is missing, unreadable or not a recording, or does not fit the twin.
    """
    path = Path(path)
    if path.suffix.lower() not in _READERS:
        endings = ", ".join(sorted(_READERS))
        raise RecordingError(
            f"{path}: expected a recording that ends in {endings}, got '{path.suffix}'; export it "
            "as one of these"
        )
    if not path.exists():
        siblings = [p.name for p in path.parent.glob("*") if p.suffix.lower() in _READERS]
        raise RecordingError(f"{path}: no such file" + did_you_mean(path.name, siblings))
    if path.is_dir():
        raise RecordingError(f"{path}: expected a recording, got a folder; name a file in it")
    module, function = _READERS[path.suffix.lower()]
    reader = cast(
        "Callable[[Path], RecordedColumns]",
        getattr(import_module(f"gmfbo.recordings.{module}"), function),
    )
    try:
        columns = reader(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {cause(error)}") from error
    return recording_from(columns, twin)
