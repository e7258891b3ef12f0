"""Recordings as Apache Parquet: a table whose columns carry units and whose nulls are blank."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column, FileNotes, RecordedColumns
from gmfbo.recordings.csv.header import split_unit
from gmfbo.recordings.formats.optional_package import load_package

_UNIT_KEYS = (b"unit", b"units", b"Unit", b"Units")
_TICKS_PER_S = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


def read_parquet(path: Path) -> RecordedColumns:
    """Read the columns of a Parquet file.

    A column's unit is its metadata `unit`, or stands in brackets after its name. Numbers in the
    metadata of the file are scalars. A column of timestamps, as data frames have for their index,
    is the clock: seconds since its first row.

    Raises
    ------
    RecordingError
        The file is no Parquet file, or pyarrow is not installed.
    OSError
        The file cannot be read.
    """
    arrow = load_package("pyarrow", "parquet", path.name)
    parquet = load_package("pyarrow.parquet", "parquet", path.name)
    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        # The file alone: pyarrow would take its folder for a part of a larger table.
        table = parquet.ParquetFile(path).read()
    except (arrow.ArrowException, OSError, ValueError) as error:
        raise RecordingError(
            f"{path.name}: expected a Parquet file, got something else or a damaged one ({error}); "
            "write or copy it again, or give it its right ending"
        ) from error
    metadata = table.schema.metadata or {}
    start = ""
    columns = []
    for name, entry, data in zip(table.column_names, table.schema, table.columns, strict=True):
        column, began = _column(arrow, path.name, name, entry, data)
        columns.append(column)
        start = start or began
    start = metadata.get(b"start_time", start.encode()).decode("utf-8", "replace")
    return RecordedColumns(
        label=path.name,
        columns=tuple(columns),
        scalars=_scalars(metadata),
        notes=FileNotes(start_time=start),
    )


def _column(arrow: Any, label: str, name: str, entry: Any, data: Any) -> tuple[Column, str]:
    name, unit = split_unit(name)
    for key in _UNIT_KEYS:
        unit = (entry.metadata or {}).get(key, unit.encode()).decode("utf-8", "replace")
    kind = entry.type
    if arrow.types.is_timestamp(kind) or arrow.types.is_duration(kind):
        values, began = _seconds(arrow, data, kind)
        if entry.name.startswith("__index_level_"):
            name = "time"
        return Column(name, values, "s"), began
    if arrow.types.is_decimal(kind) or arrow.types.is_boolean(kind) or _is_number(arrow, kind):
        if arrow.types.is_boolean(kind):
            data = data.cast(arrow.int8())
        # A null becomes NaN.
        numbers = data.cast(arrow.float64(), safe=False).to_numpy()
        return Column(name, np.array(numbers, dtype=np.float64), unit), ""
    fault = f"{label}: column '{name}': expected numbers, got {kind}; write them as numbers"
    return Column(name, np.full(len(data), np.nan), unit, fault), ""


def _is_number(arrow: Any, kind: Any) -> bool:
    return bool(arrow.types.is_integer(kind) or arrow.types.is_floating(kind))


def _seconds(arrow: Any, data: Any, kind: Any) -> tuple[NDArray[np.float64], str]:
    """Seconds since the first row, subtracted as integers, since floats would lose digits."""
    ticks = data.cast(arrow.int64()).combine_chunks()
    known = np.array(ticks.is_valid().to_pylist(), dtype=bool)
    count = np.asarray(ticks.fill_null(0).to_numpy(zero_copy_only=False), dtype=np.int64)
    first = int(count[known][0]) if known.any() and arrow.types.is_timestamp(kind) else 0
    seconds = (count - first).astype(np.float64) / _TICKS_PER_S[kind.unit]
    seconds[~known] = np.nan
    if not (arrow.types.is_timestamp(kind) and known.any()):
        return seconds, ""
    began = np.datetime64(first, kind.unit)
    return seconds, str(began.astype("datetime64[us]")) + ("Z" if kind.tz else "")


def _scalars(metadata: Mapping[bytes, bytes]) -> dict[str, float]:
    found = {}
    for key, value in metadata.items():
        try:
            found[key.decode()] = float(value)
        except ValueError:
            continue  # a text, such as the schema that pandas writes
    return found
