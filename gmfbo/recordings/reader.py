"""Read the columns of a recording; the ending of the file name gives the format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.files.durable import cause
from gmfbo.recordings.columns.columns import RecordedColumns, with_short_names
from gmfbo.recordings.reading_process.reading_process import Reader, read_apart

if TYPE_CHECKING:
    from gmfbo.recordings.columns.channels import RecordedChannels

_HDF5 = (".h5", ".hdf5")
_MDF = (".mdf", ".mf4")
_FOREIGN = (*_HDF5, *_MDF, ".mat", ".parquet", ".tdms")  # read by other packages' libraries

_TEXT = (".csv", ".txt", ".tsv", ".dat", ".log", ".lvm")
_ENDINGS = {*_TEXT, *_FOREIGN}


def read_columns(
    path: str | Path,
    dialect: str = "auto",
    wanted: Iterable[str] | None = None,
    *,
    every: bool = False,
) -> RecordedColumns:
    """Read the columns of a file, before a twin gives them a meaning.

    Parameters
    ----------
    path : str or Path
        As for `gmfbo.recordings.recording.read_recording`.
    dialect : str
        How a text file is written: one of `gmfbo.recordings.columns.column_mapping.DIALECTS`.
    wanted : iterable of str, optional
        Names that are needed; a file of channels is read on their clocks.
    every : bool
        Keep all channels of such a file.

    Raises
    ------
    RecordingError
        The file is missing, unreadable or not a recording.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in _ENDINGS:
        endings = ", ".join(sorted(_ENDINGS))
        raise RecordingError(
            f"{path}: expected a recording that ends in {endings}, got '{path.suffix}'; export it "
            "as one of these"
        )
    if not path.exists():
        siblings = [p.name for p in path.parent.glob("*") if p.suffix.lower() in _ENDINGS]
        raise RecordingError(f"{path}: no such file" + did_you_mean(path.name, siblings))
    if path.is_dir():
        raise RecordingError(f"{path}: expected a recording, got a folder; name a file in it")
    try:
        read = _read_text(path, dialect) if ending in _TEXT else _read_foreign(path, ending)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {cause(error)}") from error
    if isinstance(read, RecordedColumns):
        return with_short_names(read, wanted or ())
    return read.columns(wanted, every=every)


def _read_text(path: Path, dialect: str) -> RecordedColumns | RecordedChannels:
    from gmfbo.recordings.csv.table import read_csv

    return read_csv(path, dialect)


def _read_foreign(path: Path, ending: str) -> RecordedColumns | RecordedChannels:
    with path.open("rb"):  # a file without read permission has its own error
        pass
    return read_apart(path, _foreign_reader(ending))


def _foreign_reader(ending: str) -> Reader:
    """The reader of a format; its module loads its library only when a file is read."""
    if ending in _HDF5:
        from gmfbo.recordings.formats.hdf5_file import read_hdf5

        return read_hdf5
    if ending in _MDF:
        from gmfbo.recordings.formats.mdf_file import read_mdf

        return read_mdf
    if ending == ".mat":
        from gmfbo.recordings.formats.mat_file import read_mat

        return read_mat
    if ending == ".parquet":
        from gmfbo.recordings.formats.parquet_file import read_parquet

        return read_parquet
    from gmfbo.recordings.formats.tdms_file import read_tdms

    return read_tdms
