"""Recordings as MATLAB files, v5 through SciPy and v7.3 (an HDF5 file) through h5py."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import RecordedColumns
from gmfbo.recordings.columns.equal_length import columns_of_equal_length
from gmfbo.recordings.formats.hdf5_file import open_hdf5

_NUMBERS = {
    "double", "single", "logical", "int8", "uint8", "int16", "uint16",
    "int32", "uint32", "int64", "uint64",
}  # fmt: skip


def read_mat(path: Path) -> RecordedColumns:
    """Read the vectors and scalars of a MATLAB file.

    Fields of structures are named `structure.field`. Vectors may lie either way.

    Raises
    ------
    RecordingError
        The file is no MATLAB file, or holds no clock.
    OSError
        The file cannot be read.
    """
    arrays = _read_v73(path) if h5py.is_hdf5(path) else _read_v5(path)
    return columns_of_equal_length(path.name, arrays, units={})


def _read_v5(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        content = loadmat(path, simplify_cells=True)
    except Exception as error:  # any exception may come out of SciPy's reader
        raise RecordingError(
            f"{path.name}: expected a MATLAB file of version 5 or 7.3, got something else "
            f"({error}); save it again with `save -v7`"
        ) from error
    return dict(_flat({n: v for n, v in content.items() if not n.startswith("__")}, ""))


def _flat(content: Mapping[str, Any], prefix: str) -> list[tuple[str, Any]]:
    found = []
    for name, value in content.items():
        if isinstance(value, Mapping):
            found += _flat(value, f"{prefix}{name}.")
        else:
            found.append((prefix + name, value))
    return found


def _read_v73(path: Path) -> dict[str, Any]:
    arrays: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:
        matlab_class = item.attrs.get("MATLAB_class", b"double")
        text = matlab_class.decode() if isinstance(matlab_class, bytes) else str(matlab_class)
        # `#refs#` holds the targets of cells and objects.
        if isinstance(item, h5py.Dataset) and text in _NUMBERS and not name.startswith("#"):
            empty = "MATLAB_empty" in item.attrs
            arrays[name.replace("/", ".")] = np.empty(0) if empty else item[()]

    with open_hdf5(path, "a MATLAB") as file:
        file.visititems(visit)
    return arrays
