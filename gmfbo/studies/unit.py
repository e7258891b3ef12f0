"""Units of work that a campaign sends to workers, and their results, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.recordings.store.memory_store import StudyRecord
from gmfbo.studies.outcome import Outcome
from gmfbo.studies.study_files import StudyFiles
from gmfbo.tuning.query.method import Method


@dataclass(frozen=True, eq=False)
class Unit:
    """One method on one seed of a study, or the grid of its plant.

    Attributes
    ----------
    label : str
        Unique name within the campaign.
    files : StudyFiles
        The study, with its seed.
    truth : mapping of str to str
        Name of each known grid of the plant = SHA-256 of its content.
    method : str, Method or None
        Method that proposes, or its name where workers know it. None runs the plant over the
        whole box.
    key : str
        Hash of the content that all runs of the comparison share.
    side : int
        Points along a side of the grid of the true optimum.
    keep : bool
        Whether all trials come back, not only the outcome.
    version : str
        Version of gmfbo, which the worker must have too.
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
    """Result of a unit.

    Attributes
    ----------
    outcome : Outcome or None
        None for a unit that runs the plant over the whole box.
    truth : mapping of str to bytes
        New grids of the plant, by name.
    record : StudyRecord or None
        All trials, if the unit keeps them.
    """

    outcome: Outcome | None
    truth: Mapping[str, bytes]
    record: StudyRecord | None = None


@dataclass(frozen=True)
class Missing:
    """A worker lacks contents; send the unit again with them.

    Attributes
    ----------
    hashes : frozenset of str
        SHA-256 of each.
    """

    hashes: frozenset[str]


@dataclass(frozen=True)
class Failed:
    """A unit that cannot be run.

    Attributes
    ----------
    reason : str
        One line.
    """

    reason: str


Result = Made | Missing | Failed
