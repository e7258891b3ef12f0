"""What a campaign sends to a worker, and what comes back: values alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.recordings.store.memory_store import StudyRecord
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.study_files import StudyFiles
from gmfbo.tuning.query.method import Method


@dataclass(frozen=True, eq=False)
class Unit:
    """One method on one seed of a study, or the truth about its plant.

    Attributes
    ----------
    label : str
        Names it; no two units of a campaign share one.
    files : StudyFiles
        The study, with its seed.
    truth : mapping of str to str
        Name of each grid of the plant that is known already = SHA-256 of its content.
    method : str, Method or None
        Who proposes; its name is enough where workers know it. None runs the plant all over
        the box.
    key : str
        Hash of what all runs of the comparison share.
    side : int
        Points along a side of the grid that gives the truth.
    keep : bool
        All trials come back, not only what they came to.
    version : str
        Of gmfbo, which must be the worker's too.
    """

    label: str
    files: StudyFiles
    truth: Mapping[str, str]
    method: str | Method | None
    key: str
    side: int
    keep: bool
    version: str

    @property
    def hashes(self) -> frozenset[str]:
        """Contents that a worker must have."""
        return frozenset({*self.files.hashes.values(), *self.truth.values()})


@dataclass(frozen=True, eq=False)
class Made:
    """What a unit came to.

    Attributes
    ----------
    outcome : Outcome or None
        None of a unit that runs the plant all over the box.
    truth : mapping of str to bytes
        Grids of the plant that were not known before, by name.
    record : StudyRecord or None
        All trials, where the unit is to keep them.
    """

    outcome: Outcome | None
    truth: Mapping[str, bytes]
    record: StudyRecord | None = None


@dataclass(frozen=True)
class Missing:
    """A worker lacks contents; the unit is to be sent again with them.

    Attributes
    ----------
    hashes : frozenset of str
        SHA-256 of each.
    """

    hashes: frozenset[str]


@dataclass(frozen=True)
class Failed:
    """A unit cannot be done.

    Attributes
    ----------
    reason : str
        One line.
    """

    reason: str


Result = Made | Missing | Failed
