"""Versions of a twin that is corrected during a study, and the interface of refiners."""

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
    """A corrected twin that replaces the previous one as IS2.

    Attributes
    ----------
    number : int
        1, 2, 3 ...; 0 is the twin as the study file names it.
    source : Source
        The twin; its content hash distinguishes its runs from those of other versions.
    reason : str
        Reason of the change, in one sentence.
    details : mapping of str to object
        JSON that is logged with it, such as estimated parameters.
    """

    number: int
    source: Source
    reason: str
    details: Mapping[str, Any] = field(default_factory=dict)


class TwinRefiner(Protocol):
    """Corrects a twin from the real runs of a study."""

    def revise(self, history: History) -> TwinVersion | None:
        """Correct the twin by the newest real run and the twin's run at its gains.

        The result must follow from the runs and the logged versions alone, so that a killed study
        resumes exactly.

        Returns
        -------
        TwinVersion or None
            None where the twin is left as it is.
        """
        ...

    def restore(self, event: Mapping[str, Any]) -> TwinVersion:
        """Restore a logged version.

        Parameters
        ----------
        event : mapping of str to object
            Of `events.jsonl`.
        """
        ...

    def close(self) -> None:
        """Close opened twins and files."""
        ...


@runtime_checkable
class RefiningMethod(Method, Protocol):
    """A method whose twin is corrected after each real run; it queries the real axis only."""

    def refiner(self, twin: Source, folder: Path) -> TwinRefiner | None:
        """Open the refiner of a twin; None where this twin cannot be corrected.

        Parameters
        ----------
        twin : Source
            IS2 as the study file names it.
        folder : Path
            Folder for files of the versions; made when first needed.
        """
        ...
