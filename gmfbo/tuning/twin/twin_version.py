"""A twin that is corrected while a study runs: what whoever corrects it tells the loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from gmfbo.sources.plants.source import Source
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.method import Method


@dataclass(frozen=True, eq=False)
class TwinVersion:
    """A twin that takes the place of the one before it as IS2.

    Attributes
    ----------
    number : int
        1, 2, 3 ...; 0 is the twin as the study file names it.
    source : Source
        Runs it; its content hash tells its runs from those of other versions.
    reason : str
        Why it changed, in one sentence for people.
    details : mapping of str to object
        Logged with it, such as estimated parameters; JSON.
    """

    number: int
    source: Source
    reason: str
    details: Mapping[str, Any] = field(default_factory=dict)


class TwinRefiner(Protocol):
    """Corrects a twin from the real runs of a study."""

    def revise(self, history: History) -> TwinVersion | None:
        """Look at the newest real run, and at the twin's run beside it, which are on disk.

        Must follow from the runs and the logged versions alone, so that a killed study goes on
        as if it had not been.

        Parameters
        ----------
        history : History
            All runs.

        Returns
        -------
        TwinVersion or None
            None where the twin is left as it is.
        """
        ...

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        """Bring back a version that was logged.

        Parameters
        ----------
        event : mapping of str to object
            Of `events.jsonl`.
        """
        ...

    def close(self) -> None:
        """Give back what was opened for it."""
        ...


@runtime_checkable
class RefiningMethod(Method, Protocol):
    """A method whose twin is corrected after each real run; it asks the real axis alone."""

    def refiner(self, twin: Source, folder: Path) -> TwinRefiner | None:
        """Return who corrects the twin; None where this twin cannot be corrected.

        Parameters
        ----------
        twin : Source
            IS2 as the study file names it.
        folder : Path
            For files that belong to the versions; made when first needed.
        """
        ...
