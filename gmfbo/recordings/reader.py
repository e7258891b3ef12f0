"""Read a recording: the ending of the file name decides how."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.recordings.column_mapping import ColumnMapping, MappedReading, rename_columns
from gmfbo.recordings.columns import RecordedColumns
from gmfbo.recordings.durable import cause
from gmfbo.recordings.interpretation import recording_from
from gmfbo.recordings.signal import SignalSpec

if TYPE_CHECKING:
    from gmfbo.recordings.channels import RecordedChannels
    from gmfbo.recordings.recording import Recording
    from gmfbo.recordings.signal import SignalReading

# Module and function of what is read through a foreign library.
_FOREIGN = {
    ".h5": ("hdf5_file", "read_hdf5"),
    ".hdf5": ("hdf5_file", "read_hdf5"),
    ".mat": ("mat_file", "read_mat"),
    ".mdf": ("mdf_file", "read_mdf"),
    ".mf4": ("mdf_file", "read_mdf"),
    ".parquet": ("parquet_file", "read_parquet"),
    ".tdms": ("tdms_file", "read_tdms"),
}

_TEXT = (".csv", ".txt")
_ENDINGS = {*_TEXT, *_FOREIGN}


def read_recording(
    path: str | Path,
    twin: SignalReading | None = None,
    *,
    mapping: ColumnMapping | None = None,
) -> Recording:
    """Read a recording from a file.

    Parameters
    ----------
    path : str or Path
        `.csv` (`.txt`), `.h5` (`.hdf5`), `.mat`, `.parquet`, `.mf4` (`.mdf`) or `.tdms`.
    twin : SignalReading or None
        Says which columns are signals, with scale, offset and unit, and which names are FMU
        parameters. Without it each column is a signal and each single value a parameter.
    mapping : ColumnMapping or None
        Says how this logger names the columns; that of the twin unless given.

    Returns
    -------
    Recording
        In SI units, named after the file.

    Raises
    ------
    RecordingError
        The file is missing, unreadable or not a recording, or does not fit the twin.
    """
    words = _Words() if twin is None else _Words(twin.signal_specs(), twin.parameter_tunable())
    if mapping is None:
        mapping = twin.column_mapping() if isinstance(twin, MappedReading) else ColumnMapping()
    wanted = mapping.names() | words.names()
    file = read_columns(path, mapping.dialect, wanted if twin is not None else mapping.names())
    file, specs = rename_columns(file, mapping, words.specs)
    return recording_from(file, None if twin is None else _Words(specs, words.tunable))


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
        As for `read_recording`.
    dialect : str
        How a text file is written: one of `gmfbo.recordings.column_mapping.DIALECTS`.
    wanted : iterable of str, optional
        Names that are needed; decides on whose clock a file of channels is read.
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
    return read if isinstance(read, RecordedColumns) else read.columns(wanted, every=every)


def _read_text(path: Path, dialect: str) -> RecordedColumns | RecordedChannels:
    from gmfbo.recordings.csv_file import read_csv

    return read_csv(path, dialect)


def _read_foreign(path: Path, ending: str) -> RecordedColumns | RecordedChannels:
    from gmfbo.recordings.reading_process import read_apart

    with path.open("rb"):  # a missing right to read is an error of its own
        pass
    module, function = _FOREIGN[ending]
    return read_apart(path, f"gmfbo.recordings.{module}", function)


@dataclass(frozen=True)
class _Words:
    """What a reader asks of a twin, after its column mapping."""

    specs: Mapping[str, SignalSpec] = field(default_factory=dict)
    tunable: Mapping[str, bool] = field(default_factory=dict)

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        return self.specs

    def parameter_tunable(self) -> Mapping[str, bool]:
        return self.tunable

    def names(self) -> frozenset[str]:
        """Names that a file may use for what the twin knows."""
        columns = (spec.column for spec in self.specs.values())
        return frozenset((*self.specs, *columns, *self.tunable))
