"""Information source: a plant or twin that can run an experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from gmfbo.recordings.recording import Recording


class Source(Protocol):
    """Runs one experiment at given gains; a failed run is a result, not an exception."""

    @property
    def name(self) -> str:
        """Name for messages."""
        ...

    @property
    def content_hash(self) -> str:
        """Hash of all content that decides the outcome; empty for a real axis."""
        ...

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Follow the reference at these gains, and return the trajectory.

        Parameters
        ----------
        gains : mapping of str to float
            All gains by name [unit of the FMU parameter].
        reference : Recording
            Reference to follow.
        """
        ...

    def close(self) -> None:
        """Give back processes and files."""
        ...
