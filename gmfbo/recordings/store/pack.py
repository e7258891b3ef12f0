"""A study as one self-contained HDF5 file, for others and for MATLAB."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from gmfbo.errors import RecordingError, StoreError
from gmfbo.files.durable import cause, write_whole
from gmfbo.recordings.reading_process.reading_process import try_apart
from gmfbo.recordings.store.events import EventLines, read_events
from gmfbo.recordings.store.index import trial_name
from gmfbo.recordings.store.memory_store import StudyRecord
from gmfbo.recordings.store.seal import read_seal, sealed
from gmfbo.recordings.store.study_reading import FolderReading
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.store.trial_file import check_digest, read_trial_group, write_trial_group
from gmfbo.recordings.writing.hdf5_group import DIGEST, content_digest, content_of, file_image


def pack_study(folder: str | Path, path: str | Path) -> Path:
    """Write a study folder as one HDF5 file.

    The group `/trials/000001` has the content of that trial's file; the attributes `study` and
    `events` of the root are the study file and the lines of `events.jsonl`. A running study is
    packed with its finished trials.

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

    def copy(trials: Any) -> None:
        for number in study.numbers():
            _copy_trial(study, number, trials)

    name = study.location.resolve().name
    return _write_pack(Path(path), name, study.study_text(), study.intact_event_lines(), copy)


def pack_record(record: StudyRecord, path: str | Path) -> Path:
    """Write a study in memory as one HDF5 file, as `pack_study` does for a folder.

    Parameters
    ----------
    record : StudyRecord
        Content of the study.
    path : str or Path
        File to write, ending `.h5`; an older one is replaced.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    target = Path(path)

    def write(trials: Any) -> None:
        for trial in record.trials:
            write_trial_group(trials.create_group(trial_name(trial.number)), trial)

    return _write_pack(target, target.stem, record.study_text, record.event_lines, write)


def _write_pack(
    target: Path, name: str, text: str, lines: Sequence[str], write: Callable[[Any], None]
) -> Path:
    if target.suffix.lower() not in (".h5", ".hdf5"):
        raise StoreError(f"{target}: expected a file name that ends in .h5, got '{target.suffix}'")

    def fill(root: Any) -> None:
        root.attrs["packed_study"] = name
        root.create_dataset("study", data=text, dtype=h5py.string_dtype())
        root.create_dataset(
            "events", data=list(lines), shape=(len(lines),), dtype=h5py.string_dtype()
        )
        write(root.create_group("trials"))

    image = sealed(file_image(fill))
    try:
        write_whole(target, image)
    except OSError as error:
        raise StoreError(f"{target}: cannot write the packed study: {cause(error)}") from error
    return target


def _copy_trial(study: FolderReading, number: int, trials: Any) -> None:
    study.read_trial(number)  # refuses a damaged file
    with h5py.File(study.trial_path(number), "r", locking=False) as file:
        trials.copy(file["/"], trial_name(number))
    packed = trials[trial_name(number)]
    packed.attrs[DIGEST] = content_digest(content_of(packed))  # a file of an early version has none


class PackedReading:
    """Reads a packed study.

    Parameters
    ----------
    path : Path
        File that `pack_study` wrote.

    Raises
    ------
    StoreError
        The file is no packed study, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.location = path
        try:
            seal = read_seal(path.read_bytes()).state
        except OSError as error:
            raise StoreError(f"{path}: cannot be read: {cause(error)}") from error
        if seal == "damaged":
            raise _damaged_pack(path, "its checksum does not fit its content")
        if seal == "absent":
            try:
                # Damage in HDF5 may crash its reader, so another process tries first.
                try_apart(path, try_packed)
            except RecordingError as error:
                raise StoreError(
                    f"{path}: expected a study folder or a packed study, but it is no "
                    f"readable HDF5 file ({error})"
                ) from error
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

    @contextmanager
    def _open(self) -> Iterator[Any]:
        try:
            with h5py.File(self.location, "r", locking=False) as file:
                yield file
        except StoreError:
            raise
        except Exception as error:  # any exception may come out of h5py
            raise _damaged_pack(self.location, f"{type(error).__name__}: {error}") from error


def try_packed(path: Path) -> None:
    """Read a packed study where a crash does no harm; other HDF5 files are accepted."""
    with h5py.File(path, "r", locking=False) as file:
        if "packed_study" in file.attrs:
            for group in file["trials"].values():
                read_trial_group(group)
                if DIGEST in group.attrs:  # an early version wrote none
                    check_digest(group)


def _damaged_pack(path: Path, why: str) -> StoreError:
    return StoreError(
        f"{path}: expected a packed study, but it is damaged ({' '.join(why.split())}); run "
        f"`gmfbo repair {path}`, which saves what can be saved into a folder"
    )
