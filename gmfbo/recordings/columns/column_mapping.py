"""Column mapping: names of a logger's columns, written once and used for each recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np

from gmfbo.errors import InputError, did_you_mean
from gmfbo.recordings.columns.columns import Column, RecordedColumns
from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.units import parse_unit

DIALECTS = ("auto", "plain", "decimal_comma", "twincat_scope")


@dataclass(frozen=True)
class MappedColumn:
    """A column of the file and its conversion: value [unit] = scale * column + offset.

    Attributes
    ----------
    column : str
        Name in the file.
    unit : str
        Unit of the value; empty for the unit stated in the file.
    scale : float or None
        [unit / column unit]; if given, the file's unit is ignored, and an empty `unit` means SI.
    offset : float
        [unit]
    sample_time : float or None
        [s] Of `time` in files without a clock: time between two rows; `column` is then empty.
    """

    column: str
    unit: str = ""
    scale: float | None = None
    offset: float = 0.0
    sample_time: float | None = None

    @property
    def converts(self) -> bool:
        """Whether it converts the numbers; the twin file's scale and offset then do not apply."""
        return bool(self.unit) or self.scale is not None or self.offset != 0.0


@dataclass(frozen=True)
class ColumnMapping:
    """Columns by the names that the twin file uses.

    Attributes
    ----------
    columns : mapping of str to MappedColumn
        By signal, FMU parameter, `time`, or another name that the recording shall use.
    dialect : str
        How a text file is written: one of `DIALECTS`.
    """

    columns: Mapping[str, MappedColumn] = field(default_factory=dict)
    dialect: str = "auto"

    def names(self) -> frozenset[str]:
        """Names in the file."""
        return frozenset(entry.column for entry in self.columns.values() if entry.column)

    @property
    def sample_time(self) -> float | None:
        """[s] Time between two rows of files without a clock; None where they have one."""
        clock = self.columns.get("time")
        return None if clock is None else clock.sample_time

    @property
    def states_time(self) -> bool:
        """Whether it says in which unit the clock is; then that is the last word."""
        clock = self.columns.get("time")
        return clock is not None and (clock.converts or clock.sample_time is not None)


@runtime_checkable
class MappedReading(Protocol):
    """A twin whose file maps the logger's column names."""

    def column_mapping(self) -> ColumnMapping:
        """Return the mapping."""
        ...


def rename_columns(
    file: RecordedColumns, mapping: ColumnMapping, specs: Mapping[str, SignalSpec]
) -> tuple[RecordedColumns, Mapping[str, SignalSpec]]:
    """Give columns the names that the twin file uses.

    A column that the file lacks is ignored, and the twin file's own names count. Files that gmfbo
    wrote already name signals, and stay unchanged.

    Parameters
    ----------
    file : RecordedColumns
        As read.
    mapping : ColumnMapping
        Columns by name.
    specs : mapping of str to SignalSpec
        Of the twin; empty without one.

    Returns
    -------
    file : RecordedColumns
        With renamed columns.
    specs : mapping of str to SignalSpec
        Without scale and offset where the mapping converts the numbers.
    """
    if file.notes.own or not mapping.columns:
        return file, specs
    file = _counted(file, mapping.sample_time)
    by_name = {column.name: column for column in file.columns}
    present = {n: e for n, e in mapping.columns.items() if e.column in by_name}
    if not present:
        return file, specs
    changed = dict(specs)
    renamed: dict[str, Column] = {}
    for name, entry in present.items():
        spec = specs.get(name)
        if spec is not None and entry.converts:
            changed[name] = replace(spec, scale=1.0, scaled=False, offset=0.0)
        target = name if spec is None else spec.column
        renamed[target] = _converted(by_name[entry.column], entry, target)
    used = {entry.column for entry in present.values()}
    kept = [c for c in file.columns if c.name not in used and c.name not in renamed]
    return replace(file, columns=(*renamed.values(), *kept)), changed


def check_settings(
    settings: Mapping[str, MappedColumn], file: RecordedColumns, units: Mapping[str, str]
) -> None:
    """Refuse what `--set` says of columns, where it cannot be.

    Parameters
    ----------
    settings : mapping of str to MappedColumn
        Columns by name; entries without a column are left to others.
    file : RecordedColumns
        As read.
    units : mapping of str to str
        SI unit by name; of the others any known unit is taken.

    Raises
    ------
    InputError
        There is no such column, or its unit is not known or of another quantity.
    """
    for name, entry in settings.items():
        fault = setting_fault(name, entry, file, units.get(name, ""))
        if fault:
            raise InputError(f"--set: {fault}")


def setting_fault(name: str, entry: MappedColumn, file: RecordedColumns, unit: str) -> str:
    """Say why a column cannot be that of a signal; empty where it can.

    Parameters
    ----------
    name : str
        Of the signal, or `time`.
    entry : MappedColumn
        What was stated; an entry without a column is left to others.
    file : RecordedColumns
        As read.
    unit : str
        SI unit of the signal; empty where any is taken.
    """
    names = [column.name for column in file.columns]
    if entry.column and entry.column not in names:
        return f"{file.label} has no column '{entry.column}' for '{name}'" + did_you_mean(
            entry.column, names
        )
    stated, wanted = parse_unit(entry.unit), parse_unit(unit)
    if not entry.unit:
        return ""
    if stated is None:
        return f"unit [{entry.unit}] of '{name}' is not known; expected such as rad, deg"
    scaled = entry.scale is not None or stated.needs_scale
    if wanted is not None and stated.dimension != wanted.dimension and not scaled:
        return (
            f"[{entry.unit}] is no unit of '{name}'; expected [{unit}] or another of its quantity"
        )
    return ""


def _counted(file: RecordedColumns, sample_time: float | None) -> RecordedColumns:
    """The file with a column `time` [s] that counts its rows, instead of one that it may have."""
    if sample_time is None or not file.columns:
        return file
    rows = np.arange(file.columns[0].values.size, dtype=np.float64)
    others = [column for column in file.columns if column.name != "time"]
    return replace(file, columns=(Column("time", sample_time * rows, "s"), *others))


def _converted(column: Column, entry: MappedColumn, name: str) -> Column:
    if entry.scale is None and entry.offset == 0.0:
        return replace(column, name=name, unit=entry.unit or column.unit)
    scale = 1.0 if entry.scale is None else entry.scale
    unit = entry.unit or (column.unit if entry.scale is None else "")
    return replace(column, name=name, values=scale * column.values + entry.offset, unit=unit)
