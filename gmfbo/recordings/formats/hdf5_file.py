"""Recordings as HDF5: a trial or trajectory of ours, or plain datasets of equal length."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import Column, FileNotes, RecordedColumns
from gmfbo.recordings.columns.equal_length import columns_of_equal_length
from gmfbo.recordings.formats.hdf5_group import group_content, is_recording_group


def read_hdf5(path: Path) -> RecordedColumns:
    """Read the columns of an HDF5 file.

    Plain files hold datasets of equal length, also in groups (`group/name`) and in tables of
    several fields (`table/field`), with an attribute `unit` or `units`;
    single values and numeric attributes of the root are scalars.

    Raises
    ------
    RecordingError
        The file is no HDF5 file, is a whole study, or holds no clock.
    OSError
        The file cannot be read.
    """
    with open_hdf5(path, "an HDF5") as file:
        if is_recording_group(file):
            return _ours(path.name, file)
        if "trials" in file and isinstance(file["trials"], h5py.Group):
            raise RecordingError(
                f"{path.name}: expected one recording, got a study of {len(file['trials'])} "
                "trials; name the file of one trial, such as trials/000001.h5 of the study folder"
            )
        return _plain(path.name, file)


@contextmanager
def open_hdf5(path: Path, kind: str) -> Iterator[Any]:
    """Open an HDF5 file for reading, without a lock.

    Parameters
    ----------
    path : Path
        File.
    kind : str
        Expected kind of file, with its article, for the message.

    Raises
    ------
    RecordingError
        It is no HDF5 file, or a damaged one.
    OSError
        The file cannot be opened.
    """
    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        raise RecordingError(
            f"{path.name}: expected {kind} file, got something else or a damaged one ({error}); "
            "write or copy it again, or give it its right ending"
        ) from error


def _ours(label: str, file: Any) -> RecordedColumns:
    """Columns of a recording or trial of ours, so that a twin can give them a meaning."""
    attributes = dict(file.attrs)
    content, run = group_content(file, attributes)
    gains = dict(
        zip(map(str, attributes.get("gain_names", ())), attributes.get("gains", ()), strict=True)
    )
    written_by = content["written_by"]
    if run is not None:  # a trial file states it among its versions
        written_by = written_by or str(attributes.get("version.gmfbo", ""))
    named = {**content["signals"], **content["schedules"]}
    columns = [Column("time", content["time"], "s")]
    columns += [Column(n, values, content["units"].get(n, "")) for n, values in named.items()]
    return RecordedColumns(
        label=label,
        columns=tuple(columns),
        scalars={**content["parameters"], **gains},
        declared=True,
        notes=FileNotes(
            use=content["use"],
            start_time=content["start_time"],
            written_by=written_by,
            own=True,
            schedules=frozenset(content["schedules"]),
            run=run,
        ),
    )


def _plain(label: str, file: Any) -> RecordedColumns:
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return
        if item.external or item.is_virtual:
            raise RecordingError(
                f"{label}: '{name}' keeps its numbers in another file; write them into this one"
            )
        if item.dtype.names:  # a table: each field is a column
            content = item[()]
            arrays.update({f"{name}/{part}": content[part] for part in item.dtype.names})
            return
        arrays[name] = item[()]
        unit = item.attrs.get("unit", item.attrs.get("units", ""))
        units[name] = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)

    file.visititems(visit)
    for name, value in file.attrs.items():
        if np.ndim(value) == 0 and np.asarray(value).dtype.kind in "biuf":
            arrays.setdefault(name, value)
    return columns_of_equal_length(label, arrays, units)
