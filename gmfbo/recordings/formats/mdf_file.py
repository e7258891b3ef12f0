"""Recordings as ASAM MDF, the files of CANape, INCA and many loggers, through asammdf."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.channels import Channel, RecordedChannels
from gmfbo.recordings.columns.columns import FileNotes
from gmfbo.recordings.formats.optional_package import load_package


def read_mdf(path: Path) -> RecordedChannels:
    """Read the channels of an MDF file of version 3 or 4.

    Each channel has the clock of its group, its conversion is applied, samples marked invalid are
    left out. Numbers among the common properties of the file's header are scalars.

    Raises
    ------
    RecordingError
        The file is no MDF file, or asammdf is not installed.
    OSError
        The file cannot be read.
    """
    asammdf = load_package("asammdf", "mdf", path.name)
    with path.open("rb"):  # a file without read permission has its own error
        pass
    try:
        with asammdf.MDF(path) as file:
            channels = tuple(_channels(file))
            scalars = _common_properties(getattr(file.header, "comment", "") or "")
            start = file.start_time.isoformat()
    except OSError:
        raise
    except Exception as error:  # any exception may come out of asammdf
        raise RecordingError(
            f"{path.name}: expected an MDF file, got something else or a damaged one "
            f"({' '.join(str(error).split())}); copy it again, or give it its right ending"
        ) from error
    return RecordedChannels(path.name, channels, scalars, FileNotes(start_time=start))


def _channels(file: Any) -> Iterator[Channel]:
    for number, group in enumerate(file.groups):
        name = str(getattr(group.channel_group, "acq_name", "") or f"group {number}")
        for index, _ in enumerate(group.channels):
            if index == file.masters_db.get(number):
                continue
            signal = file.get(group=number, index=index)
            values = np.asarray(signal.samples)
            if values.ndim != 1 or values.dtype.kind not in "biuf":
                continue  # text, an array, a structure
            yield Channel(
                name=signal.name,
                time=np.asarray(signal.timestamps, dtype=np.float64),
                values=values.astype(np.float64),
                unit=str(signal.unit or "").strip(),
                group=name,
            )


def _common_properties(comment: str) -> dict[str, float]:
    """Numbers by name in the XML of the header's comment."""
    try:
        entries = ElementTree.fromstring(comment).iter()
    except ElementTree.ParseError:
        return {}  # a plain text
    found = {}
    for entry in entries:
        # Some writers state a name space.
        if entry.tag.rpartition("}")[2] == "e" and entry.get("name"):
            try:
                found[str(entry.get("name"))] = float(entry.text or "")
            except ValueError:
                continue  # the author, the project
    return found
