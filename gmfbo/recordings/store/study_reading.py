"""Reading of studies: interface, and the study folder."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from gmfbo.errors import StoreError
from gmfbo.files.durable import cause
from gmfbo.recordings.store.events import EventLines, parse_event_line, read_events
from gmfbo.recordings.store.index import trial_name
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.store.trial_file import read_trial_file

STUDY_NAME = "study.toml"
EVENTS_NAME = "events.jsonl"


class StudyReading(Protocol):
    """A readable study, in a folder or packed."""

    location: Path

    def study_text(self) -> str:
        """Study file as given."""
        ...

    def numbers(self) -> list[int]:
        """Numbers of the trials that are there, increasing."""
        ...

    def read_trial(self, number: int) -> Trial:
        """Read one trial that is there."""
        ...

    def event_lines(self) -> EventLines:
        """Events in the order in which they happened."""
        ...


class FolderReading:
    """Reads a study folder, without any lock: also while a writer is at work.

    Parameters
    ----------
    folder : Path
        `NAME.study`.

    Raises
    ------
    StoreError
        There is no such folder, or it is no study.
    """

    def __init__(self, folder: Path) -> None:
        self.location = folder
        if not folder.is_dir():
            raise StoreError(
                f"{folder}: expected a study folder or a packed study, but there is none; "
                "check the path"
            )
        if not (folder / STUDY_NAME).is_file():
            raise StoreError(
                f"{folder}: expected a study folder, but it holds no {STUDY_NAME}; "
                "name the folder that `gmfbo tune` wrote"
            )

    def study_text(self) -> str:
        """Study file as given."""
        # Line ends are not translated, so the text stays the same to the byte.
        try:
            return self._read(STUDY_NAME).decode("utf-8")
        except UnicodeDecodeError as error:
            raise StoreError(
                f"{self.location / STUDY_NAME}: expected UTF-8 text, but it is damaged "
                f"({error}); run `gmfbo repair {self.location}`"
            ) from error

    def numbers(self) -> list[int]:
        """Numbers of the trial files, increasing; temporary and other files do not count."""
        return sorted(
            int(path.stem)
            for path in (self.location / "trials").glob("*.h5")
            if path.stem.isdecimal() and path.stem == trial_name(int(path.stem))
        )

    def read_trial(self, number: int) -> Trial:
        """Read one trial file."""
        return read_trial_file(self.trial_path(number))

    def trial_path(self, number: int) -> Path:
        """Path of this trial's file, existing or not."""
        return self.location / "trials" / f"{trial_name(number)}.h5"

    def event_lines(self) -> EventLines:
        """Events, and the lines that are damaged."""
        if not (self.location / EVENTS_NAME).exists():
            return EventLines([], [])
        return read_events(self._read(EVENTS_NAME))

    def intact_event_lines(self) -> list[str]:
        """Lines of the events that pass their checksum, without line ends."""
        path = self.location / EVENTS_NAME
        lines = (
            self._read(EVENTS_NAME).decode(errors="replace").split("\n") if path.exists() else []
        )
        return [line for line in lines if parse_event_line(line) is not None]

    def _read(self, name: str) -> bytes:
        path = self.location / name
        try:
            return path.read_bytes()
        except OSError as error:
            raise StoreError(f"{path}: cannot be read: {cause(error)}") from error
