"""Write a recording as an HDF5 group, and an HDF5 file as bytes in memory."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording, Trajectory

DIGEST = "digest"
"""Attribute of a trial: digest of all other content, whatever its layout in HDF5."""

LAYOUT = 1  # version of the layout below, attribute `layout`

_NUMBER = h5py.h5t.py_create(np.dtype(np.float64))
_TEXT_TYPE = h5py.string_dtype()
_TEXT = h5py.h5t.py_create(_TEXT_TYPE, logical=True)
_SCALAR = h5py.h5s.create_simple(())

_names_in_memory = itertools.count()


def file_image(fill: Callable[[Any], None]) -> bytes:
    """Build an HDF5 file in memory, by `fill` of its root group, and return its bytes.

    HDF5 itself never writes to the disk: on a full disk it would crash the interpreter.
    """
    name = f"in memory {next(_names_in_memory)}"
    with h5py.File(name, "w", driver="core", backing_store=False) as file:
        fill(file["/"])  # each access to `file.attrs` would open it anew
        file.flush()
        return bytes(file.id.get_file_image())


@dataclass(frozen=True, eq=False)
class Dataset:
    """A dataset of a group, or a group in it.

    Attributes
    ----------
    values : ndarray or None
        None for a group.
    attributes : mapping of str to any
        As h5py takes them.
    """

    values: NDArray[Any] | None
    attributes: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class GroupContent:
    """All that an HDF5 group holds.

    Attributes
    ----------
    attributes : dict of str to any
        Of the group, as h5py takes them.
    datasets : dict of str to Dataset
        By their path in the group.
    """

    attributes: dict[str, Any] = field(default_factory=dict)
    datasets: dict[str, Dataset] = field(default_factory=dict)

    def add_column(
        self, name: str, values: NDArray[np.float64], kind: str, unit: str | None
    ) -> None:
        """Add a dataset, shape (n,), with the attributes `kind` and, where known, `unit`.

        Raises
        ------
        RecordingError
            There is a column of this name.
        """
        if name in self.datasets:
            raise RecordingError(
                f"column '{name}': cannot be stored in HDF5, there are two columns of this name; "
                "rename it"
            )
        attributes = {"kind": kind} if unit is None else {"kind": kind, "unit": unit}
        self.datasets[name] = Dataset(np.ascontiguousarray(values, dtype=np.float64), attributes)

    def add_values(self, prefix: str, values: Mapping[str, float]) -> None:
        """Add each value as the attribute `<prefix>.<name>`.

        Raises
        ------
        RecordingError
            A value is no number.
        """
        for name, value in values.items():
            try:
                number = float(np.asarray(value, dtype=np.float64).reshape(()))
            except (TypeError, ValueError) as error:
                raise RecordingError(
                    f"{prefix} '{name}': cannot be stored, expected a number, got {value!r}"
                ) from error
            self.attributes[f"{prefix}.{name}"] = number


def texts(given: Iterable[str]) -> NDArray[Any]:
    """List of texts, shape (n,), as an attribute holds it."""
    array: NDArray[Any] = np.array(list(given), dtype=_TEXT_TYPE)
    return array


def recording_content(recording: Recording) -> GroupContent:
    """One dataset a column, and other fields of the recording as attributes.

    Parameters
    ----------
    recording : Recording
        Signals and parameter schedules become datasets with the attributes `kind` and `unit`.

    Raises
    ------
    RecordingError
        Two columns have one name.
    """
    content = GroupContent()
    attributes = content.attributes
    attributes["layout"] = LAYOUT
    for key in ("name", "start_time", "written_by"):
        attributes[key] = getattr(recording, key)
    if recording.use is not None:
        attributes["use"] = np.array(recording.use)
    # HDF5 lists datasets by name, so the order of the columns is stored.
    attributes["signals"] = texts(recording.signals)
    attributes["schedules"] = texts(recording.schedules)
    content.add_values("parameter", recording.parameters)
    if isinstance(recording, Trajectory):
        attributes["trajectory.status"] = recording.status
        attributes["trajectory.message"] = recording.message
        attributes["trajectory.seconds"] = recording.seconds
        if recording.stopped_at is not None:
            attributes["trajectory.stopped_at"] = recording.stopped_at
    content.add_column("time", recording.time, "time", "s")
    for name, values in recording.signals.items():
        content.add_column(name, values, "signal", recording.units.get(name))
    for name, values in recording.schedules.items():
        content.add_column(name, values, "schedule", recording.units.get(name))
    return content


def write_content(group: Any, content: GroupContent) -> None:
    """Write a group's content.

    Parameters
    ----------
    group : h5py.Group
        Empty group; the root of a trial file.
    content : GroupContent
        What it is to hold.

    Raises
    ------
    RecordingError
        HDF5 cannot hold a name of a dataset or an attribute.
    """
    # Before the columns: a file that is cut off loses its end.
    _write_attributes(group, content.attributes)
    for name, dataset in content.datasets.items():
        try:
            if any(part in ("", ".") for part in name.split("/")):
                raise ValueError("a path that HDF5 would take for another")
            written = group.create_dataset(name, data=dataset.values)
        except (ValueError, OSError, RuntimeError, TypeError) as error:
            raise RecordingError(
                f"column '{name}': cannot be stored in HDF5, HDF5 refuses the name; rename it"
            ) from error
        _write_attributes(written, dataset.attributes)


def _write_attributes(item: Any, attributes: Mapping[str, Any]) -> None:
    """As `item.attrs` would, in a third of its time: a trial has a hundred attributes."""
    for name, value in attributes.items():
        try:
            key = name.encode()
        except UnicodeEncodeError as error:  # of bytes that are no text
            raise _refused_name(name) from error
        if b"\0" in key:
            raise _refused_name(name)
        if not isinstance(value, str | float):
            item.attrs[name] = value
            continue
        kind, array = (
            (_TEXT, np.array(value, dtype=_TEXT_TYPE))
            if isinstance(value, str)
            else (_NUMBER, np.array(value, dtype=np.float64))
        )
        h5py.h5a.create(item.id, key, kind, _SCALAR).write(array)


def _refused_name(name: str) -> RecordingError:
    return RecordingError(
        f"{name!a}: cannot be stored in HDF5, which would not give this name back; rename it"
    )


def content_of(group: Any) -> GroupContent:
    """All that a group holds."""
    content = GroupContent(dict(group.attrs))

    def add(name: str, item: Any) -> None:
        values = item[()] if isinstance(item, h5py.Dataset) else None
        content.datasets[name] = Dataset(values, dict(item.attrs))

    group.visititems(add)
    return content


def content_digest(content: GroupContent) -> str:
    """BLAKE2b of all names and values except the digest, whatever their layout in HDF5."""
    digest = hashlib.blake2b(digest_size=16)

    def add(name: str, dataset: Dataset) -> None:
        digest.update(f"{name}\n".encode("utf-8", "surrogatepass"))
        for key, value in sorted(dataset.attributes.items()):
            text = f"{key} = {np.asarray(value).tolist()!r}\n"
            digest.update(text.encode("utf-8", "surrogatepass"))
        if dataset.values is not None:
            digest.update(np.ascontiguousarray(dataset.values).tobytes())

    own = {key: value for key, value in content.attributes.items() if key != DIGEST}
    add("", Dataset(None, own))
    groups = {
        "/".join(parts[:depth])
        for parts in (name.split("/") for name in content.datasets)
        for depth in range(1, len(parts))
    }
    items = {name: Dataset(None, {}) for name in groups} | content.datasets
    for name in sorted(items, key=_as_hdf5_lists):
        add(name, items[name])
    return digest.hexdigest()


def _as_hdf5_lists(name: str) -> list[bytes]:
    """Order of `h5py.Group.visititems`: by name, a group before what it holds."""
    return [part.encode("utf-8", "surrogateescape") for part in name.split("/")]
