"""Columns or channels of a file as bytes, for another process: a line of JSON, then the numbers.

Pickle is not used: code that a hostile file injects must not run in the process that asked.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import Column, FileNotes, RecordedColumns


def write_columns(stream: IO[bytes], read: RecordedColumns | RecordedChannels | None) -> None:
    """Write the result of a reader.

    Parameters
    ----------
    stream : file
        Binary, open for writing.
    read : RecordedColumns, RecordedChannels or None
        Numbers are written as 64-bit floats, and `row_name` is dropped. None for a mere trial.
    """
    if read is None:
        stream.write(b"null\n")
        return
    arrays: list[NDArray[np.float64]] = []
    places: dict[int, int] = {}

    def place(values: NDArray[np.float64]) -> int:
        if id(values) not in places:  # channels of one group share their clock
            places[id(values)] = len(arrays)
            arrays.append(values)
        return places[id(values)]

    head: dict[str, Any] = {"label": read.label, "scalars": dict(read.scalars)}
    head["notes"] = {**asdict(read.notes), "schedules": sorted(read.notes.schedules)}
    if isinstance(read, RecordedColumns):
        head["declared"], head["unreadable"] = read.declared, dict(read.unreadable)
        head["columns"] = [
            (c.name, place(c.values), c.unit, c.fault, c.assumed) for c in read.columns
        ]
    else:
        head["channels"] = [
            (c.name, place(c.time), place(c.values), c.unit, c.group, c.alias, c.fault, c.counted)
            for c in read.channels
        ]
    head["sizes"] = [array.size for array in arrays]
    stream.write(json.dumps(head, default=_plain).encode("ascii") + b"\n")
    for array in arrays:
        stream.write(np.ascontiguousarray(array, dtype=np.float64).data.cast("B"))


def write_refusal(stream: IO[bytes], message: str) -> None:
    """Write why a file cannot be read."""
    stream.write(json.dumps({"refused": message}).encode("ascii") + b"\n")


def read_columns_from(stream: IO[bytes]) -> RecordedColumns | RecordedChannels | str | None:
    """Read the stream of `write_columns`, or the message of `write_refusal`.

    Raises
    ------
    EOFError
        The stream ended early.
    ValueError
        The stream holds something else.
    """
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    head = json.loads(line)
    if head is None:
        return None
    if "refused" in head:
        return str(head["refused"])
    arrays = list(_arrays(stream, head["sizes"]))
    notes = head["notes"]
    use = notes["use"]
    file_notes = FileNotes(
        **{
            **notes,
            "use": None if use is None else (use[0], use[1]),
            "schedules": frozenset(notes["schedules"]),
        }
    )
    if "columns" in head:
        return RecordedColumns(
            label=head["label"],
            columns=tuple(Column(n, arrays[k], unit, f, a) for n, k, unit, f, a in head["columns"]),
            scalars=head["scalars"],
            declared=head["declared"],
            unreadable=head["unreadable"],
            notes=file_notes,
        )
    return RecordedChannels(
        label=head["label"],
        channels=tuple(
            Channel(name, arrays[time], arrays[values], *rest)
            for name, time, values, *rest in head["channels"]
        ),
        scalars=head["scalars"],
        notes=file_notes,
    )


def _arrays(stream: IO[bytes], sizes: list[int]) -> Iterator[NDArray[np.float64]]:
    for size in sizes:
        array = np.empty(size, dtype=np.float64)
        view, filled = array.data.cast("B") if size else memoryview(b""), 0
        while filled < len(view):
            count = stream.readinto(view[filled:])  # type: ignore[attr-defined]
            if not count:
                raise EOFError
            filled += count
        yield array


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"no JSON for {type(value).__name__}")
