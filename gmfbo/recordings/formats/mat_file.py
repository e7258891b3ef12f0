"""Recordings as MATLAB files, v4 and v5 through SciPy and v7.3 (an HDF5 file) through h5py."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import RecordedChannels
from gmfbo.recordings.columns.columns import RecordedColumns
from gmfbo.recordings.formats.hdf5_file import open_hdf5
from gmfbo.recordings.formats.mat_layouts import MatlabObject, recorded_content
from gmfbo.recordings.formats.modelica_result import is_modelica_result, read_modelica_result

_NUMBERS = {
    "double", "single", "logical", "int8", "uint8", "int16", "uint16",
    "int32", "uint32", "int64", "uint64",
}  # fmt: skip
_LONGEST_TEXT = 10_000  # of a name or a unit; a damaged file may claim billions
_DEEPEST = 20  # levels of structures; no logger nests more than six
_MOST_VALUES = 20_000  # fields and cells; each signal of a logger needs some ten


def read_mat(path: Path) -> RecordedColumns | RecordedChannels:
    """Read the signals and scalars of a MATLAB file.

    Read are vectors, either way round, and matrices; fields of structures are named
    `structure.field`. Known layouts are those of Simulink's scopes and To File and To Workspace
    blocks, of structures made of time series, of ControlDesk, and of Dymola and OpenModelica.

    Raises
    ------
    RecordingError
        The file is no MATLAB file, or holds no numbers.
    OSError
        The file cannot be read.
    """
    content = _read_v73(path) if h5py.is_hdf5(path) else _read_v5(path)
    if is_modelica_result(content):
        return read_modelica_result(path.name, content)
    return recorded_content(path.name, content)


def _read_v5(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatlabOpaque

    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # SciPy calls every object "None", and says so
            content = loadmat(path, simplify_cells=True)
    except Exception as error:  # any exception may come out of SciPy's reader
        raise RecordingError(
            f"{path.name}: expected a MATLAB file of version 5 or 7.3, got something else "
            f"({error}); save it again with `save -v7`"
        ) from error
    opaque = content.pop("None", None)
    if isinstance(opaque, MatlabOpaque):
        name, kind = _object(opaque)
        content[name] = MatlabObject(kind)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _object(opaque: Any) -> tuple[str, str]:
    """Name and class of an object of a v5 file, of which SciPy keeps the last."""
    try:
        fields = opaque.reshape(-1)[0]
        return fields["s0"].decode("ascii", "replace"), fields["s2"].decode("ascii", "replace")
    except (ValueError, IndexError, KeyError, AttributeError):
        return "object", "of a class that it does not state"


def _read_v73(path: Path) -> dict[str, Any]:
    with open_hdf5(path, "a MATLAB") as file:
        reader = _Version73(file)
        # `#refs#` holds the targets of cells and objects, `#subsystem#` the objects.
        return {n: reader.value(file[n], _DEEPEST) for n in file if not n.startswith("#")}


class _Version73:
    """Values of an open file; structures and cells of a damaged one may hold themselves."""

    def __init__(self, file: Any) -> None:
        self._file = file
        self._left = _MOST_VALUES
        self._within: list[Any] = []  # what holds the value that is read

    def value(self, item: Any, depth: int) -> Any:
        """Numbers, text, a list, a dict, or what MATLAB alone reads."""
        self._left -= 1
        if self._left < 0 or item in self._within:
            raise RecordingError(
                f"{Path(self._file.filename).name}: expected at most {_MOST_VALUES} values in its "
                "structures, got more, or one that holds itself; save signals as vectors"
            )
        if depth == 0:
            return None
        self._within.append(item)
        read = self._value(item, depth)
        self._within.pop()
        return read

    def _value(self, item: Any, depth: int) -> Any:
        kind = _text(item.attrs.get("MATLAB_class", b"double"))
        if "MATLAB_object_decode" in item.attrs and kind not in _NUMBERS:
            return MatlabObject(kind)
        if isinstance(item, h5py.Group):
            fields = {name: self.value(item[name], depth - 1) for name in item}
            return _struct_array(fields)
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return None
        if item.external or item.is_virtual:
            raise RecordingError(
                f"{Path(self._file.filename).name}: '{item.name}' keeps its numbers in another "
                "file; write them into this one"
            )
        if "MATLAB_empty" in item.attrs:
            return np.empty(0)
        if item.dtype == h5py.ref_dtype:
            # A cell, or a field of an array of structures.
            return _References(
                [self.value(self._file[r], depth - 1) for r in item[()].reshape(-1) if r]
            )
        if kind == "char":
            return "".join(map(chr, item[()].reshape(-1))) if item.size <= _LONGEST_TEXT else None
        return item[()].T if kind in _NUMBERS else None


class _References(list[Any]):
    """Targets of references."""


def _struct_array(fields: Mapping[str, Any]) -> Any:
    """Fields of a structure, or the list of an array of structures."""
    lengths = {len(value) for value in fields.values() if isinstance(value, _References)}
    if len(lengths) != 1 or not all(isinstance(value, _References) for value in fields.values()):
        return dict(fields)
    return [{name: value[k] for name, value in fields.items()} for k in range(lengths.pop())]


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
