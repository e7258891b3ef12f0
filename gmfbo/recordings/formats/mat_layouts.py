"""Layouts in which MATLAB, Simulink and ControlDesk save signals, as nested values.

Simulink saves a scope as a structure with `time` and `signals` (fields `values`, `label`), a time
series has the fields `Time` and `Data`, and ControlDesk writes `X` and `Y` with `Name` and `Data`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import RecordedColumns
from gmfbo.recordings.columns.equal_length import columns_of_equal_length, matrix_columns


@dataclass(frozen=True)
class MatlabObject:
    """A value that MATLAB alone reads.

    Attributes
    ----------
    name : str
        Its class, such as `timeseries`.
    """

    name: str


@dataclass
class _Found:
    label: str
    channels: list[Channel] = field(default_factory=list)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    faults: dict[str, str] = field(default_factory=dict)

    def object(self, path: str, name: str) -> None:
        """Keep an object as a column that tells how to export it."""
        series = f"{path}.get(1).Values" if name.endswith("Dataset") else path
        self.faults[path] = (
            f"{self.label}: '{path}' is a MATLAB object ({name}), which MATLAB alone reads; in "
            f"MATLAB: x = {series}; s.time = x.Time; s.position = squeeze(x.Data); "
            "save('run.mat', '-struct', 's')"
        )


def recorded_content(label: str, content: Mapping[str, Any]) -> RecordedColumns | RecordedChannels:
    """Signals and scalars of a file's variables.

    Parameters
    ----------
    label : str
        File name.
    content : mapping
        Variables by name: arrays, texts, dicts for structures, lists for cells and for arrays of
        structures, and `MatlabObject`.

    Returns
    -------
    RecordedColumns or RecordedChannels
        Channels where signals have a clock of their own.

    Raises
    ------
    RecordingError
        There are no numbers.
    """
    found = _Found(label)
    for name, value in content.items():
        _walk(found, name, value)
    if not found.channels:
        return columns_of_equal_length(label, found.arrays, {}, found.faults)
    return _with_others(found)


def _walk(found: _Found, path: str, value: Any) -> None:
    if isinstance(value, MatlabObject):
        found.object(path, value.name)
    elif isinstance(value, Mapping):
        channels = _channels(path, value)
        found.channels += channels
        for name, item in () if channels else value.items():
            _walk(found, f"{path}.{name}", item)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for number, item in enumerate(_items(value), start=1):
            _walk(found, f"{path}({number})", item)
    elif isinstance(value, np.ndarray | np.number | int | float):
        array = np.asarray(value)
        if array.dtype.kind in "biuf":
            found.arrays[path] = array


def _channels(path: str, value: Mapping[str, Any]) -> list[Channel]:
    """Channels of a structure in a known layout; none for others."""
    fields = {str(name).lower(): item for name, item in value.items()}
    if "signals" in fields and _vector(fields.get("time")) is not None:
        return list(_scope(path, fields))
    if "x" in fields and "y" in fields:
        return list(_control_desk(path, _items(fields["x"]), _items(fields["y"])))
    if "values" in fields and isinstance(fields["values"], Mapping):
        # A signal of a Dataset that was exported as a structure.
        name = _text(fields.get("name")) or path
        return list(_series(path, {str(n).lower(): v for n, v in fields["values"].items()}, name))
    return list(_series(path, fields, _text(fields.get("name")) or path))


def _scope(path: str, fields: Mapping[str, Any]) -> Iterator[Channel]:
    """Simulink's structure with time."""
    time = _vector(fields["time"])
    assert time is not None  # it was looked at before
    for number, signal in enumerate(_items(fields["signals"]), start=1):
        if not isinstance(signal, Mapping):
            continue
        name = _text(signal.get("label")) or _text(signal.get("title"))
        own = f"{path}.signals({number})"
        yield from _on_clock(name or own, own, path, time, signal.get("values"), "")


def _series(path: str, fields: Mapping[str, Any], name: str) -> Iterator[Channel]:
    """A time series that was saved as a structure."""
    time = _vector(fields.get("time"))
    if time is None or "data" not in fields:
        return
    information = fields.get("datainfo")
    units = information.get("Units") if isinstance(information, Mapping) else None
    unit = _text(units.get("Name") if isinstance(units, Mapping) else units)
    yield from _on_clock(name, path, path.rpartition(".")[0], time, fields["data"], unit)


def _control_desk(path: str, x: Sequence[Any], y: Sequence[Any]) -> Iterator[Channel]:
    clocks = [_vector(item.get("Data")) if isinstance(item, Mapping) else None for item in x]
    for item in y:
        if not isinstance(item, Mapping) or not clocks:
            continue
        index = np.asarray(item.get("XIndex", 1.0))
        place = int(index) - 1 if index.size == 1 and index.dtype.kind in "biuf" else 0
        time = clocks[place] if 0 <= place < len(clocks) else clocks[0]
        name = _text(item.get("Name"))
        if time is not None and name:
            yield from _on_clock(name, name, path, time, item.get("Data"), _text(item.get("Unit")))


def _on_clock(
    name: str, alias: str, group: str, time: NDArray[np.float64], data: Any, unit: str
) -> Iterator[Channel]:
    """Channels of an array whose last or first dimension runs along the clock."""
    array = np.asarray(data)
    if array.dtype.kind not in "biuf" or array.size == 0:
        return
    if array.ndim > 2:
        array = array.squeeze()
    columns = matrix_columns(name, array, time.size)
    if columns is None:
        fault = f"'{name}' has {array.size} values, expected {time.size} as its clock has"
        yield Channel(name, time, np.full(time.size, np.nan), unit, group, alias, fault)
        return
    for own, values in columns.items():
        yield Channel(own, time, values, unit, group, alias + own.removeprefix(name))


def _with_others(found: _Found) -> RecordedChannels:
    """Channels beside the variables of a file that are no part of a known layout."""
    scalars = {name: float(a.reshape(-1)[0]) for name, a in found.arrays.items() if a.size == 1}
    others = {name: a for name, a in found.arrays.items() if a.size > 1}
    channels = list(found.channels)
    clock = next((a for n, a in others.items() if n.rpartition(".")[2].lower() in _CLOCKS), None)
    time = channels[0].time if clock is None else clock.reshape(-1).astype(np.float64)
    for name, array in others.items():
        if array is clock:
            continue
        channels += _on_clock(name, name, "", time, array, "")
    blank = np.full(time.size, np.nan)
    channels += [Channel(n, time, blank, fault=why) for n, why in found.faults.items()]
    return RecordedChannels(found.label, tuple(channels), scalars)


_CLOCKS = ("time", "t", "tout")


def _items(value: Any) -> Sequence[Any]:
    """Elements of an array of structures or of a cell; a single one is a list of one."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        return value.reshape(-1).tolist()
    return value if isinstance(value, list) else [value]


def _vector(value: Any) -> NDArray[np.float64] | None:
    if value is None or isinstance(value, Mapping | list | str | MatlabObject):
        return None
    array = np.asarray(value)
    if array.dtype.kind not in "biuf" or array.size < 2 or array.size != max(array.shape):
        return None
    return array.reshape(-1).astype(np.float64)


def _text(value: Any) -> str:
    return value.strip() if isinstance(value, str) else ""
