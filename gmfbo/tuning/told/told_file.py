"""Read a told recording by the twin file, and refuse a file that was told before."""

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
    """A told recording and its file.

    Attributes
    ----------
    recording : Recording
        The recording.
    file : str
        Its path; empty for a recording in memory.
    sha256 : str
        Hash of the file's bytes; empty without a file.
    """

    recording: Recording
    file: str = ""
    sha256: str = ""

    @classmethod
    def read(
        cls, told: Recording | str | Path, reading: SignalReading | None, reference: Recording
    ) -> Self:
        """Read a told recording.

        Parameters
        ----------
        told : Recording, str or Path
            The recording, or its file.
        reading : SignalReading or None
            Meaning of a file's columns.
        reference : Recording
            Requested reference; a file is shifted to its clock.

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
        """Raise for a file that was told before, since it would count double.

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
