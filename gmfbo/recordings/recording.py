"""Recordings and trajectories: frozen signals over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError, did_you_mean
from gmfbo.recordings.columns.column_mapping import ColumnMapping, MappedReading, rename_columns
from gmfbo.recordings.columns.columns import RecordedColumns, find_clock
from gmfbo.recordings.columns.interpretation import interpreted
from gmfbo.recordings.columns.row_spacing import check_spacing
from gmfbo.recordings.columns.signal import (
    ResampledReading,
    SignalReading,
    SignalSpec,
    SteppedReading,
)
from gmfbo.recordings.columns.unit_in_name import notes_on_units, with_units_of_names
from gmfbo.recordings.reader import read_columns

Status = Literal["ok", "diverged", "failed", "timeout", "crashed", "unsafe"]


def _frozen(
    values: Mapping[str, NDArray[np.float64]], rows: int
) -> Mapping[str, NDArray[np.float64]]:
    frozen = {}
    for name, column in values.items():
        array = np.array(column, dtype=np.float64)
        if array.shape != (rows,):
            raise RecordingError(
                f"signal '{name}': expected {rows} values, one a time, got shape {array.shape}"
            )
        array.setflags(write=False)
        frozen[name] = array
    return MappingProxyType(frozen)


@dataclass(frozen=True, eq=False)
class Recording:
    """Signals of one run in SI units; row k holds what a logger sees at `time[k]`.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s], strictly increasing, need not begin at zero.
    signals : mapping of str to ndarray, shape (n,)
        Values by the user's signal name; NaN where a signal was not sampled.
    units : mapping of str to str
        SI unit of each signal; absent where unknown.
    name : str
        File name or another label.
    parameters : mapping of str to float
        FMU parameters in force during the run, such as the gains.
    schedules : mapping of str to ndarray, shape (n,)
        FMU parameters that changed during the run.
    use : tuple of float or None
        [s] First and last time that may be scored.
    start_time : str
        ISO 8601 time of the first row; empty where unknown.
    written_by : str
        gmfbo version that wrote the file; empty for files of others.
    notes : tuple of str
        What its reader took from names of columns, or from one of two statements.
    """

    time: NDArray[np.float64]
    signals: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    schedules: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    use: tuple[float, float] | None = None
    start_time: str = ""
    written_by: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time = np.array(self.time, dtype=np.float64)
        if time.ndim != 1 or time.size == 0:
            raise RecordingError(f"{self.name or 'recording'}: expected at least one row, got none")
        if not np.all(np.isfinite(time)):
            raise RecordingError(f"{self.name or 'recording'}: time holds NaN or infinity")
        if np.any(np.diff(time) <= 0.0):
            row = int(np.argmax(np.diff(time) <= 0.0)) + 1
            raise RecordingError(
                f"{self.name or 'recording'}: time must increase, "
                f"row {row} has {time[row]:g} s after {time[row - 1]:g} s"
            )
        time.setflags(write=False)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "signals", _frozen(self.signals, time.size))
        object.__setattr__(self, "schedules", _frozen(self.schedules, time.size))
        # No text in HDF5 holds a NUL, which a vendor's message in a C buffer may end with.
        for text in fields(self):
            value = getattr(self, text.name)
            if isinstance(value, str) and "\x00" in value:
                object.__setattr__(self, text.name, value.replace("\x00", "\ufffd"))
        object.__setattr__(self, "units", MappingProxyType(dict(self.units)))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle as plain dicts, since read-only views of a dict cannot be pickled."""
        values = (getattr(self, field.name) for field in fields(self))
        return type(self), tuple(
            dict(value) if isinstance(value, Mapping) else value for value in values
        )

    @classmethod
    def read(cls, path: str | Path, twin: SignalReading | None = None) -> Recording:
        """Read a recording; the ending of the file name decides how.

        Parameters
        ----------
        path : str or Path
            `.csv`, `.h5` or `.mat`.
        twin : FmuTwin or TwinFile, optional
            Tells which columns are signals, with scale, offset and unit; without it each
            column is a signal under its own name.

        Raises
        ------
        RecordingError
            The file cannot be read or does not fit the twin.
        """
        return read_recording(Path(path), twin)

    def signal(self, name: str) -> NDArray[np.float64]:
        """Values of one signal, shape (n,).

        Parameters
        ----------
        name : str
            The user's name of it.

        Raises
        ------
        RecordingError
            There is no such signal; the message names the nearest.
        """
        if name not in self.signals:
            label = self.name or "recording"
            raise RecordingError(f"{label}: no signal '{name}'" + did_you_mean(name, self.signals))
        return self.signals[name]

    def with_signals(self, signals: Mapping[str, NDArray[np.float64]]) -> Self:
        """Return a copy with these signals added or replaced, each of shape (n,).

        Parameters
        ----------
        signals : mapping of str to ndarray, shape (n,)
            Values [SI] by name.
        """
        return replace(self, signals={**self.signals, **signals})

    @property
    def duration(self) -> float:
        """[s] From the first to the last row."""
        return float(self.time[-1] - self.time[0])

    def __len__(self) -> int:
        return int(self.time.size)

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{name} [{self.units[name]}]" if name in self.units else name for name in self.signals
        )
        label = f" '{self.name}'" if self.name else ""
        kind = type(self).__name__
        return f"<{kind}{label}: {len(self)} rows, {self.duration:g} s, signals {shown}>"


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Recording):
    """A simulated run: row k is read at communication point k, before the inputs of k act.

    Attributes
    ----------
    status : str
        `ok`, or how the run ended early; then the rows up to that time are kept.
    message : str
        Cause of the end, in one line; empty when `status` is `ok`.
    stopped_at : float or None
        [s] Time of the communication point that failed.
    seconds : float
        [s] Wall-clock time of the run.
    """

    status: Status = "ok"
    message: str = ""
    stopped_at: float | None = None
    seconds: float = 0.0


def recording_of(content: Mapping[str, Any], run: Mapping[str, Any] | None) -> Recording:
    """Make a recording of these fields, or a trajectory if fields of a run are given.

    Parameters
    ----------
    content : mapping
        Fields of `Recording`.
    run : mapping or None
        Fields that `Trajectory` adds.
    """
    return Recording(**content) if run is None else Trajectory(**content, **run)


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
        Tells which columns are signals, with scale, offset and unit, and which names are FMU
        parameters. Without it each column is a signal and each single value a parameter.
    mapping : ColumnMapping or None
        Names of this logger's columns; the twin's mapping unless given.

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
    stated, mapping = mapping, with_units_of_names(file, mapping, words.specs)
    notes = notes_on_units(file, stated, mapping)
    file, specs = rename_columns(file, mapping, words.specs)
    known = None if twin is None else _Words(specs, words.tunable)
    resample = twin.resample if isinstance(twin, ResampledReading) else None
    content = interpreted(file, known, resample)
    if isinstance(twin, SteppedReading) and not stated.states_time:
        _check_spacing(file, mapping, specs, content, twin.step)
    return recording_of({**content, "notes": (*notes, *content["notes"])}, file.notes.run)


def _check_spacing(
    file: RecordedColumns,
    mapping: ColumnMapping,
    specs: Mapping[str, SignalSpec],
    content: Mapping[str, Any],
    step: float,
) -> None:
    """Refuse a clock that seems to be in another unit."""
    clock, mapped = find_clock(file.label, file.columns), mapping.columns.get("time")
    # Set points may lie as far apart as they like, and gmfbo's own clocks are in seconds.
    compared = any(name in content["signals"] for name, spec in specs.items() if spec.compared)
    if compared and not file.notes.own:
        name = clock.name if mapped is None else mapped.column
        check_spacing(file, clock, name, step)


@dataclass(frozen=True)
class _Words:
    """Signals and parameters of a twin, by which a reader interprets columns."""

    specs: Mapping[str, SignalSpec] = field(default_factory=dict)
    tunable: Mapping[str, bool] = field(default_factory=dict)

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        return self.specs

    def parameter_tunable(self) -> Mapping[str, bool]:
        return self.tunable

    def names(self) -> frozenset[str]:
        columns = (spec.column for spec in self.specs.values())
        return frozenset((*self.specs, *columns, *self.tunable))
