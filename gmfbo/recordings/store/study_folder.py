"""The folder of a study: each trial is a file, written whole or not at all."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import Any, Self

from gmfbo.errors import StoreError
from gmfbo.files.durable import cause, remove_stale, sync_folder, write_whole
from gmfbo.recordings.store.events import append_event, event_line
from gmfbo.recordings.store.index import write_index
from gmfbo.recordings.store.pack import PackedReading
from gmfbo.recordings.store.study_reading import (
    EVENTS_NAME,
    STUDY_NAME,
    FolderReading,
    StudyReading,
)
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.store.trial_file import trial_image
from gmfbo.recordings.store.writer_lock import WriterLock

LOCK_NAME = "writer.lock"

INDEX_SHARE = 0.05
"""Share of a long study's time spent on its index, which is rewritten each time."""

_SHORT_STUDY = 50


class StudyStore:
    """A study on disk, made by `create`, `open` or `open_for_writing`.

    Readers take no lock and may read while a study runs. There is one writer at a time. Data
    survives `kill -9` and a power cut once `write_trial` or `log` has returned.

    Attributes
    ----------
    location : Path
        The folder, or the packed file.
    """

    def __init__(self, reading: StudyReading, lock: WriterLock | None = None) -> None:
        self.location = reading.location
        self._reading = reading
        self._lock = lock
        self._index_due, self._index_behind = 0.0, False

    @classmethod
    def create(cls, folder: str | Path, study_text: str) -> StudyStore:
        """Make a study folder and open it for writing.

        Parameters
        ----------
        folder : str or Path
            `NAME.study`, new or empty; its parent must exist.
        study_text : str
            Study file as given.

        Raises
        ------
        StoreError
            The folder holds something already, or cannot be written.
        """
        folder = Path(folder)
        if (folder / STUDY_NAME).exists():
            raise StoreError(f"{folder}: holds a study already; resume it, or give another folder")
        # A creation that was killed leaves the lock and an empty folder of trials.
        ours = {"trials", LOCK_NAME}
        if folder.is_dir() and any(
            path.name not in ours and not path.name.endswith(".tmp") for path in folder.iterdir()
        ):
            raise StoreError(f"{folder}: expected a new or empty folder; give another one")
        lock = None
        try:
            folder.mkdir(exist_ok=True)
            lock = WriterLock(folder / LOCK_NAME)
            (folder / "trials").mkdir(exist_ok=True)
            sync_folder(folder.absolute().parent)
            write_whole(folder / STUDY_NAME, study_text.encode())
            write_index(folder, [], study_text)
        except OSError as error:
            if lock is not None:
                lock.release()
            raise StoreError(f"{folder}: cannot make the study folder: {cause(error)}") from error
        return cls(FolderReading(folder), lock)

    @classmethod
    def open(cls, path: str | Path) -> StudyStore:
        """Open a study folder or a packed study for reading; nothing is locked or changed.

        Raises
        ------
        StoreError
            There is no study at `path`.
        """
        path = Path(path)
        return cls(PackedReading(path) if path.is_file() else FolderReading(path))

    @classmethod
    def open_for_writing(cls, folder: str | Path) -> StudyStore:
        """Open a study folder as its one writer, and clean up after a killed writer.

        Unfinished files are removed; they and damaged event lines are logged as `repair`.

        Raises
        ------
        StoreError
            There is no study, another writer has it, or the folder cannot be written.
        """
        folder = Path(folder)
        if folder.is_file():
            raise StoreError(f"{folder}: a packed study can only be read; name the study folder")
        reading = FolderReading(folder)
        try:
            lock = WriterLock(folder / LOCK_NAME)
        except OSError as error:
            raise StoreError(f"{folder}: cannot open for writing: {cause(error)}") from error
        store = cls(reading, lock)
        try:
            (folder / "trials").mkdir(exist_ok=True)
            store.clear_away()
        except OSError as error:
            store.close()
            raise StoreError(f"{folder}: cannot open for writing: {cause(error)}") from error
        except StoreError:
            store.close()
            raise
        return store

    @property
    def study_text(self) -> str:
        """Study file as given."""
        return self._reading.study_text()

    def numbers(self) -> list[int]:
        """Numbers of the finished trials, increasing."""
        return self._reading.numbers()

    def next_number(self) -> int:
        """One more than the largest number of a finished trial."""
        return max(self.numbers(), default=0) + 1

    def trials(self) -> list[Trial]:
        """All finished trials in the order of their numbers."""
        return [self._reading.read_trial(number) for number in self.numbers()]

    def read_trial(self, number: int) -> Trial:
        """Read one finished trial.

        Raises
        ------
        StoreError
            There is no such trial, or its file is damaged.
        """
        numbers = self.numbers()
        if number not in numbers:
            there = f"1 to {numbers[-1]}" if numbers else "none yet"
            raise StoreError(f"{self.location}: no trial {number}; there are {there}")
        return self._reading.read_trial(number)

    def write_trial(self, trial: Trial) -> Path:
        """Write a finished trial; when this returns, it is on the disk.

        Raises
        ------
        StoreError
            The number is taken, or the file cannot be written; then nothing is left of it.
        """
        folder = self._writable()
        path = folder.trial_path(trial.number)
        if trial.number < 1:
            raise StoreError(f"{path}: expected a trial number of at least 1, got {trial.number}")
        if path.exists():
            raise StoreError(f"{path}: trial {trial.number} is stored already; number it anew")
        try:
            write_whole(path, trial_image(trial))
        except OSError as error:
            raise StoreError(
                f"{path}: cannot store trial {trial.number}: {cause(error)}"
            ) from error
        # The trial is safe by now; the next refresh updates an outdated index.
        self._index_behind = True
        if trial.number <= _SHORT_STUDY or time.monotonic() >= self._index_due:
            with contextlib.suppress(StoreError):
                self.refresh_index()
        return path

    def log(self, event: str, **fields: Any) -> None:
        """Append an event; when this returns, it is on the disk.

        Parameters
        ----------
        event : str
            Name of the event: `ask`, `tell`, `interrupt` ...
        **fields
            JSON values, or NumPy values.

        Raises
        ------
        StoreError
            The line cannot be written; the file is unchanged.
        """
        path = self._writable().location / EVENTS_NAME
        new = not path.exists()
        try:
            append_event(path, event_line(event, fields))
            if new:
                sync_folder(path.parent)
        except OSError as error:
            raise StoreError(f"{path}: cannot log '{event}': {cause(error)}") from error

    def events(self) -> list[dict[str, Any]]:
        """Intact events in the order in which they were logged."""
        return self._reading.event_lines().events

    def damaged_event_lines(self) -> list[int]:
        """Numbers (from 1) of lines of `events.jsonl` that fail their checksum."""
        return self._reading.event_lines().damaged

    def refresh_index(self) -> None:
        """Make `index.h5` show all finished trials.

        Raises
        ------
        StoreError
            The index cannot be written; an older one is untouched.
        """
        folder, began = self._writable(), time.monotonic()
        try:
            write_index(folder.location, folder.numbers(), folder.study_text())
        except OSError as error:
            raise StoreError(
                f"{folder.location}: cannot write the index: {cause(error)}"
            ) from error
        ended = time.monotonic()
        self._index_due, self._index_behind = ended + (ended - began) / INDEX_SHARE, False

    def close(self) -> None:
        """Let the next writer in; a second call does nothing."""
        if self._lock is not None:
            if self._index_behind:
                with contextlib.suppress(StoreError):
                    self.refresh_index()
            self._lock.release()
            self._lock = None

    def clear_away(self) -> list[str]:
        """Remove a killed writer's files, log them and new damaged lines, rebuild the index.

        Returns
        -------
        list of str
            Names of the unfinished files that were removed.

        Raises
        ------
        StoreError
            The folder cannot be written.
        """
        folder = self._writable().location
        unfinished = [*remove_stale(folder), *remove_stale(folder / "trials")]
        lines = self._reading.event_lines()
        told = {
            line
            for event in lines.events
            if event["event"] == "repair"
            for line in event.get("damaged_lines", ())
        }
        damaged = [line for line in lines.damaged if line not in told]
        if unfinished or damaged:
            self.log("repair", unfinished_files=unfinished, damaged_lines=damaged)
        self.refresh_index()
        return unfinished

    def _writable(self) -> FolderReading:
        if self._lock is None or not isinstance(self._reading, FolderReading):
            raise StoreError(
                f"{self.location}: open for reading only; use StudyStore.open_for_writing"
            )
        return self._reading

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
