"""Columns of a file, before a twin gives them a meaning."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.units import parse_unit

CLOCK_NAMES = ("time", "t", "timestamp", "zeit", "tout")
"""Names by which a clock is found, in lower case, the likeliest first."""


@dataclass(frozen=True, eq=False)
class Column:
    """One column as it stands in the file.

    Attributes
    ----------
    name : str
        Name without the unit.
    values : ndarray, shape (n,)
        NaN where the file has no number.
    unit : str
        As written; empty where none is.
    fault : str
        Message about the first cell that holds something else than a number; empty if none does.
    assumed : bool
        Nothing in the file states the unit: the first column of a matrix, taken for a clock in s.
    """

    name: str
    values: NDArray[np.float64]
    unit: str = ""
    fault: str = ""
    assumed: bool = False


@dataclass(frozen=True)
class FileNotes:
    """Metadata of a file.

    Attributes
    ----------
    use : tuple of float or None
        [s] First and last time that may be scored.
    start_time : str
        ISO 8601; empty where unknown.
    written_by : str
        gmfbo version that made the signals; empty for those of other loggers.
    own : bool
        gmfbo wrote the file: columns are signals by name, in SI, scale and offset applied.
    schedules : frozenset of str
        Columns that a file of ours declares to be parameter schedules.
    run : mapping or None
        Fields of a Trajectory, where a file of ours holds a simulated run.
    """

    use: tuple[float, float] | None = None
    start_time: str = ""
    written_by: str = ""
    own: bool = False
    schedules: frozenset[str] = frozenset()
    run: Mapping[str, Any] | None = None


@dataclass(frozen=True, eq=False)
class RecordedColumns:
    """Content of a file, before a twin gives it a meaning.

    Attributes
    ----------
    label : str
        File name, for messages.
    columns : tuple of Column
        In the file's order, all of one length, the clock among them.
    scalars : mapping of str to float
        Single values: candidates for FMU parameters in force.
    declared : bool
        Whether scalars are declared as parameters, so that an unknown name is an error.
    unreadable : mapping of str to str
        Messages about declared scalars that are no numbers, by name.
    notes : FileNotes
        Metadata of the file.
    row_name : callable
        Place of row k (from 0) in the file, for messages.
    """

    label: str
    columns: tuple[Column, ...]
    scalars: Mapping[str, float] = field(default_factory=dict)
    declared: bool = False
    unreadable: Mapping[str, str] = field(default_factory=dict)
    notes: FileNotes = field(default_factory=FileNotes)
    row_name: Callable[[int], str] = field(default=lambda row: f"row {row + 1}")

    def refuse(self, why: str) -> RecordingError:
        """Make an error that names the file."""
        return RecordingError(f"{self.label}: {why}")


def find_clock(label: str, columns: tuple[Column, ...]) -> Column:
    """Column with one of `CLOCK_NAMES`, or else the first whose unit is one of time.

    Raises
    ------
    RecordingError
        There is none; the message names the columns.
    """
    for name in CLOCK_NAMES:
        for column in columns:
            # T is a temperature.
            if column.name == name or (name != "t" and column.name.lower() == name):
                return column
        for column in columns:
            # MATLAB structures and HDF5 groups: log.time, log/time
            if column.name.replace("/", ".").endswith(f".{name}"):
                return column
    for column in columns:
        unit = parse_unit(column.unit)
        if unit is not None and unit.si == "s":
            return column
    names = ", ".join(column.name for column in columns[:8])
    raise RecordingError(
        f"{label}: expected a column 'time' or 't', or one in [s] or [ms], got columns {names}; "
        "say which is the clock with 'gmfbo columns'; where there is none, state "
        "[columns] time = { sample_time = 1e-3 } in the twin file"
    )


def has_clock(columns: tuple[Column, ...]) -> bool:
    """Whether `find_clock` finds one among these columns."""
    try:
        find_clock("", columns)
    except RecordingError:
        return False
    return True


def last_part(name: str) -> str:
    """`position` of `log.position`, `drive/position` or `Model Root/plant/position`."""
    return re.split(r"[./]", name)[-1]


def with_short_names(file: RecordedColumns, wanted: Iterable[str]) -> RecordedColumns:
    """Name a column `log.position` simply `position`, where that is wanted and means no other.

    Parameters
    ----------
    file : RecordedColumns
        As read.
    wanted : iterable of str
        Names that a twin or a mapping asks for.
    """
    wanted = set(wanted)
    known = {column.name for column in file.columns}
    new: dict[str, str] = {}
    for want in wanted - known:
        full = [name for name in known - wanted if last_part(name) == want]
        if len(full) == 1:
            new[full[0]] = want
    if not new:
        return file
    columns = tuple(replace(c, name=new.get(c.name, c.name)) for c in file.columns)
    return replace(file, columns=columns)
