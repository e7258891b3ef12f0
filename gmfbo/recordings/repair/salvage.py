"""Recover content of a damaged HDF5 file; runs in the reading process, as HDF5 may crash."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.files.durable import write_whole
from gmfbo.recordings.columns.clock import JITTER
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.index import trial_name
from gmfbo.recordings.store.seal import without_seal
from gmfbo.recordings.store.trial_file import check_digest, read_trial_group, trial_image
from gmfbo.recordings.writing.writer import write_recording

_END_AT = 40  # [B] where a superblock of version 0 states the end of the file
_MOST_MISSING = 2**30  # [B]


def save_signals(path: Path, out: str) -> None:
    """Write the readable signals of a damaged trial file as a recording.

    Parameters
    ----------
    path : Path
        Damaged trial file.
    out : str
        `.h5` file to write.

    Raises
    ------
    RecordingError
        The times cannot be read, or no signal.
    """
    with _opened(path) as (file, held):
        time = _values(file, "time", held)
        rows = 0 if time is None else _steady_rows(time)
        if time is None or rows < 2:
            raise RecordingError("the times cannot be read")
        signals, units = {}, {}
        for name in file:
            values = _values(file, name, held)
            if name != "time" and values is not None and values.shape == time.shape:
                signals[name] = values[:rows]
                with contextlib.suppress(Exception):
                    units[name] = str(file[name].attrs["unit"])
        gains = {}
        with contextlib.suppress(Exception):
            names = map(str, file.attrs["gain_names"])
            gains = dict(zip(names, map(float, file.attrs["gains"]), strict=True))
    if not signals:
        raise RecordingError("no signal can be read")
    write_recording(Recording(time[:rows], signals, units, path.name, gains), out)


def save_packed_study(path: Path, folder: str) -> None:
    """Write the study file of a damaged packed study, and its events where they can be read."""
    with _opened(path) as (file, _):
        write_whole(Path(folder) / "study.toml", file["study"].asstr()[()].encode("utf-8"))
        with contextlib.suppress(Exception):
            lines = [*file["events"].asstr()[()], ""]
            write_whole(Path(folder) / "events.jsonl", "\n".join(lines).encode("utf-8"))


def list_packed_trials(path: Path, out: str) -> None:
    """Write the numbers of the trials of a damaged packed study, a line each."""
    with _opened(path) as (file, _):
        numbers = sorted(int(name) for name in file["trials"])
    write_whole(Path(out), "".join(f"{number}\n" for number in numbers).encode())


def save_packed_trial(path: Path, number: str, folder: str) -> None:
    """Write one trial of a damaged packed study as a trial file, if its digest is right.

    Raises
    ------
    RecordingError
        Its content contradicts its digest.
    """
    name = trial_name(int(number))
    with _opened(path) as (file, _):
        group = file["trials"][name]
        check_digest(group)
        image = trial_image(read_trial_group(group))
    write_whole(Path(folder) / f"{name}.h5", image)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, int]]:
    """The file, padded with zeros where it was cut off, and its true number of bytes."""
    content = without_seal(path.read_bytes())
    held = len(content)
    if held >= _END_AT + 8:
        (end,) = struct.unpack_from("<Q", content, _END_AT)
        if held < end < held + _MOST_MISSING:
            content = content.ljust(end, b"\0")
    with h5py.File(h5py.h5f.open_file_image(content)) as file:
        yield file, held


def _steady_rows(time: NDArray[np.float64]) -> int:
    """Number of rows before the first damaged value of the clock."""
    if time.size < 2 or not np.isfinite(time[0]):
        return 0
    with np.errstate(all="ignore"):
        steps = np.diff(time)
        step = float(np.median(steps[np.isfinite(steps)])) if np.isfinite(steps).any() else 0.0
        broken = ~(np.abs(steps - step) <= JITTER / 2.0 * step)
    return int(np.argmax(broken)) + 1 if broken.any() else time.size


def _values(file: Any, name: str, held: int) -> NDArray[np.float64] | None:
    """One column, shape (n,); None where it cannot be read or was cut off."""
    try:
        dataset = file[name]
        begin = dataset.id.get_offset()
        if begin is None or begin + dataset.nbytes > held:
            return None
        values = np.asarray(dataset[()], dtype=np.float64)
    except Exception:  # whatever exception HDF5 raises, the other columns may be whole
        return None
    return values if values.ndim == 1 else None
