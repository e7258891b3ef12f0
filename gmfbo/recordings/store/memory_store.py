"""A study in memory, for a process that sends it on as a value."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from gmfbo.errors import StoreError
from gmfbo.recordings.store.events import event_line, parse_event_line
from gmfbo.recordings.store.trial import Trial
from gmfbo.recordings.store.trial_file import software_versions


class TrialStore(Protocol):
    """Storage of a running study's trials and events."""

    location: Path

    def trials(self) -> list[Trial]:
        """All finished trials in the order of their numbers."""
        ...

    def events(self) -> list[dict[str, Any]]:
        """Events in the order in which they were logged."""
        ...

    def write_trial(self, trial: Trial) -> object:
        """Keep a finished trial."""
        ...

    def log(self, event: str, **fields: Any) -> None:
        """Keep an event."""
        ...

    def refresh_index(self) -> None:
        """Update the list of trials."""
        ...


@dataclass(frozen=True, eq=False)
class StudyRecord:
    """Content of a study's folder.

    Attributes
    ----------
    study_text : str
        Study file.
    event_lines : tuple of str
        Lines of `events.jsonl`, without line ends.
    trials : tuple of Trial
        In order, with the versions of the software that made them.
    """

    study_text: str
    event_lines: tuple[str, ...]
    trials: tuple[Trial, ...]


class MemoryStore:
    """A study in memory only, lost with its process.

    Parameters
    ----------
    location : Path
        Folder for files that a method makes beside its trials; need not exist.
    study_text : str
        Study file.
    """

    def __init__(self, location: Path, study_text: str) -> None:
        self.location = location
        self._text = study_text
        self._trials: dict[int, Trial] = {}
        self._lines: list[str] = []
        self._events: list[dict[str, Any]] = []

    def trials(self) -> list[Trial]:
        """All finished trials in the order of their numbers."""
        return [self._trials[number] for number in sorted(self._trials)]

    def events(self) -> list[dict[str, Any]]:
        """Events in the order in which they were logged."""
        return list(self._events)

    def write_trial(self, trial: Trial) -> None:
        """Keep a finished trial.

        Raises
        ------
        StoreError
            The number is taken, or below 1.
        """
        if trial.number < 1:
            raise StoreError(f"expected a trial number of at least 1, got {trial.number}")
        if trial.number in self._trials:
            raise StoreError(f"trial {trial.number} is stored already; number it anew")
        versions = trial.versions or software_versions()
        self._trials[trial.number] = replace(trial, versions=versions)

    def log(self, event: str, **fields: Any) -> None:
        """Keep an event.

        Parameters
        ----------
        event : str
            Name of the event.
        **fields
            JSON values, or NumPy values.
        """
        line = event_line(event, fields)
        parsed = parse_event_line(line)
        assert parsed is not None
        self._lines.append(line)
        self._events.append(parsed)

    def refresh_index(self) -> None:
        """Do nothing."""

    @property
    def record(self) -> StudyRecord:
        """The study so far, as a value that can be sent to another process."""
        return StudyRecord(self._text, tuple(self._lines), tuple(self.trials()))
