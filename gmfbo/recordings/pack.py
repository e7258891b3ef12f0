"""A study as one self-contained HDF5 file, for others and for MATLAB."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py

from gmfbo.errors import StoreError
from gmfbo.recordings.durable import cause, write_whole
from gmfbo.recordings.events import EventLines, read_events
from gmfbo.recordings.hdf5_group import file_image
from gmfbo.recordings.index import trial_name
from gmfbo.recordings.study_reading import FolderReading
from gmfbo.recordings.trial import Trial
from gmfbo.recordings.trial_file import read_trial_group


def pack_study(folder: str | Path, path: str | Path) -> Path:
    """Write a study folder as one HDF5 file.

    Under `/trials/000001` lies what the file of that trial holds; the attributes `study` and
    `events` of the root are the study file and the lines of `events.jsonl`. A study that still
    runs is packed as far as it is.

    Parameters
    ----------
    folder : str or Path
        Study folder.
    path : str or Path
        File to write, ending `.h5`; an older one is replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    StoreError
        The folder is no study, a trial is damaged, or the file cannot be written.
    """
    study = FolderReading(Path(folder))
    target = Path(path)
    if target.suffix.lower() not in (".h5", ".hdf5"):
        raise StoreError(f"{target}: expected a file name that ends in .h5, got '{target.suffix}'")

    def fill(root: Any) -> None:
        root.attrs["packed_study"] = study.location.resolve().name
        root.create_dataset("study", data=study.study_text(), dtype=h5py.string_dtype())
        lines = study.intact_event_lines()
        root.create_dataset("events", data=lines, shape=(len(lines),), dtype=h5py.string_dtype())
        trials = root.create_group("trials")
        for number in study.numbers():
            _copy_trial(study.trial_path(number), trials, trial_name(number))

    image = file_image(fill)
    try:
        write_whole(target, image)
    except OSError as error:
        raise StoreError(f"{target}: cannot write the packed study: {cause(error)}") from error
    return target


def _copy_trial(source: Path, trials: Any, name: str) -> None:
    try:
        with h5py.File(source, "r", locking=False) as file:
            trials.copy(file["/"], name)
    except (OSError, KeyError, RuntimeError) as error:
        raise StoreError(
            f"{source}: expected a whole trial file, but it is damaged ({error}); move it out of "
            "the folder to pack the others"
        ) from error


class PackedReading:
    """Reads a packed study.

    Parameters
    ----------
    path : Path
        File that `pack_study` wrote.

    Raises
    ------
    StoreError
        The file is no packed study.
    """

    def __init__(self, path: Path) -> None:
        self.location = path
        with self._open() as file:
            if "packed_study" not in file.attrs:
                raise StoreError(
                    f"{path}: expected a study folder or a packed study, but this HDF5 file is "
                    "neither; name the folder, or a file of `gmfbo export --pack`"
                )

    def study_text(self) -> str:
        """Study file as given."""
        with self._open() as file:
            return str(file["study"].asstr()[()])

    def numbers(self) -> list[int]:
        """Numbers of the trials, increasing."""
        with self._open() as file:
            return sorted(int(name) for name in file["trials"])

    def read_trial(self, number: int) -> Trial:
        """Read one trial."""
        with self._open() as file:
            return read_trial_group(file["trials"][trial_name(number)])

    def event_lines(self) -> EventLines:
        """Events in order; damaged lines were left out when the study was packed."""
        with self._open() as file:
            return read_events("\n".join(file["events"].asstr()[()]).encode())

    def _open(self) -> Any:
        try:
            return h5py.File(self.location, "r", locking=False)
        except OSError as error:
            raise StoreError(
                f"{self.location}: expected a study folder or a packed study, but it is no "
                f"readable HDF5 file ({error})"
            ) from error
