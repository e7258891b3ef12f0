"""A recording that a person tells: read as the twin file says, and never the same one twice."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from gmfbo.errors import InputError
from gmfbo.recordings.columns.signal import SignalReading
from gmfbo.recordings.recording import Recording
from gmfbo.tuning.told.real_axis import on_the_clock_of


@dataclass(frozen=True, eq=False)
class ToldRun:
    """What was told of a run.

    Attributes
    ----------
    recording : Recording
        What was measured.
    file : str
        Its path; empty where it was told from memory.
    sha256 : str
        Of the file's bytes; empty without one.
    """

    recording: Recording
    file: str = ""
    sha256: str = ""

    @classmethod
    def read(
        cls, told: Recording | str | Path, reading: SignalReading | None, reference: Recording
    ) -> Self:
        """Read what was told.

        Parameters
        ----------
        told : Recording, str or Path
            The recording, or its file.
        reading : SignalReading or None
            Says what the columns of a file are.
        reference : Recording
            What was to be followed; a file is put on its clock.

        Raises
        ------
        RecordingError
            The file cannot be read.
        """
        if isinstance(told, Recording):
            return cls(told)
        path = Path(told)
        run = on_the_clock_of(reference, Recording.read(path, reading))
        return cls(run, str(path), hashlib.sha256(path.read_bytes()).hexdigest())

    def refuse_repeated(self, events: Iterable[Mapping[str, Any]]) -> None:
        """Refuse a file that was told before: easily done at a bench, and it would count double.

        Parameters
        ----------
        events : iterable of mapping
            The study's log.

        Raises
        ------
        InputError
            It was told before.
        """
        for event in events:
            if self.sha256 and event["event"] == "tell" and event["sha256"] == self.sha256:
                raise InputError(
                    f"{self.file}: was told before, as trial {event['number']}; name the "
                    "recording of the run asked for, or take it once more with --anyway"
                )
