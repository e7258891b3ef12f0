"""Write a recording as an HDF5 group, and an HDF5 file as bytes in memory."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Mapping
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


def write_recording_group(group: Any, recording: Recording) -> None:
    """Write one dataset a column, and other fields of the recording as attributes.

    Parameters
    ----------
    group : h5py.Group
        Empty group; the root of a trial file.
    recording : Recording
        Signals and parameter schedules become datasets with the attributes `kind` and `unit`.

    Raises
    ------
    RecordingError
        Two columns have one name, or HDF5 cannot hold a name.
    """
    attributes = group.attrs
    attributes["layout"] = LAYOUT
    for key in ("name", "start_time", "written_by"):
        attributes[key] = getattr(recording, key)
    if recording.use is not None:
        attributes["use"] = np.array(recording.use)
    # HDF5 lists datasets by name, so the order of the columns is stored.
    attributes["signals"] = _texts(recording.signals)
    attributes["schedules"] = _texts(recording.schedules)
    write_values(group, "parameter", recording.parameters)
    if isinstance(recording, Trajectory):
        attributes["trajectory.status"] = recording.status
        attributes["trajectory.message"] = recording.message
        attributes["trajectory.seconds"] = recording.seconds
        if recording.stopped_at is not None:
            attributes["trajectory.stopped_at"] = recording.stopped_at
    write_column(group, "time", recording.time, "time", "s")
    for name, values in recording.signals.items():
        write_column(group, name, values, "signal", recording.units.get(name))
    for name, values in recording.schedules.items():
        write_column(group, name, values, "schedule", recording.units.get(name))


def write_column(
    group: Any, name: str, values: NDArray[np.float64], kind: str, unit: str | None
) -> None:
    """Write one dataset, shape (n,), with the attributes `kind` and, where known, `unit`."""
    try:
        if any(part in ("", ".") for part in name.split("/")):
            raise ValueError("a path that HDF5 would take for another")
        dataset = group.create_dataset(name, data=np.asarray(values, dtype=np.float64))
    except (ValueError, OSError, RuntimeError, TypeError) as error:
        why = "there are two columns of this name" if name in group else "HDF5 refuses the name"
        raise RecordingError(
            f"column '{name}': cannot be stored in HDF5, {why}; rename it"
        ) from error
    dataset.attrs["kind"] = kind
    if unit is not None:
        dataset.attrs["unit"] = unit


def write_values(group: Any, prefix: str, values: Mapping[str, float]) -> None:
    """Write each value as the attribute `<prefix>.<name>`."""
    scalar = h5py.h5s.create_simple(())
    for name, value in values.items():
        # As `group.attrs`, in a fifth of its time: a trial has a hundred attributes.
        text = f"{prefix}.{name}".encode("utf-8", "surrogateescape")
        attribute = h5py.h5a.create(group.id, text, _NUMBER, scalar)
        attribute.write(np.array(value, dtype=np.float64))


def write_texts(group: Any, name: str, texts: Mapping[str, Any] | list[str]) -> None:
    """Write a list of texts as one attribute."""
    group.attrs[name] = _texts(texts)


def _texts(texts: Mapping[str, Any] | list[str]) -> NDArray[Any]:
    array: NDArray[Any] = np.array(list(texts), dtype=h5py.string_dtype())
    return array


def group_digest(group: Any) -> str:
    """BLAKE2b of all names and values of a group except its digest, whatever their layout."""
    digest = hashlib.blake2b(digest_size=16)

    def add(name: str, item: Any) -> None:
        digest.update(f"{name}\n".encode("utf-8", "surrogatepass"))
        attributes = item.attrs
        for key in sorted(set(attributes) - {DIGEST} if item == group else attributes):
            value = np.asarray(attributes[key]).tolist()
            digest.update(f"{key} = {value!r}\n".encode("utf-8", "surrogatepass"))
        if isinstance(item, h5py.Dataset):
            digest.update(np.ascontiguousarray(item[()]).tobytes())

    add("", group)
    group.visititems(add)  # in the order of the names
    return digest.hexdigest()
