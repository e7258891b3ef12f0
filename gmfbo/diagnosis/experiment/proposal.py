"""A proposed experiment within limits: its file, detectable effects and predictions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gmfbo.diagnosis.experiment.play_limits import PlayLimits
from gmfbo.diagnosis.experiment.safe_player import Peaks
from gmfbo.diagnosis.experiment.separation import Separation
from gmfbo.diagnosis.result.named_effect import DetectableSize, NotTestable
from gmfbo.recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class ProposedExperiment:
    """The next reference, within limits.

    Attributes
    ----------
    recording : Recording
        Reference that a drive plays.
    words : str
        Its description: "a slow triangle, then a chirp".
    why : str
        What it does, as the rest of a sentence.
    limits : PlayLimits
        Limits that were given.
    peaks : Peaks
        Extremes of the simulated motion, at the twin's values and under each explanation.
    shows : mapping of str to DetectableSize
        Smallest size of each effect that it would show.
    hidden : tuple of NotTestable
        Effects that it does not show, and why.
    wanted : tuple of str
        Effects for which it was chosen; empty where it was chosen for all.
    separation : Separation or None
        How surely it would tell rivals apart; None where it was not chosen for that.
    predicted : mapping of str to str
        Predicted observation under each explanation.
    """

    recording: Recording
    words: str
    why: str
    limits: PlayLimits
    peaks: Peaks
    shows: Mapping[str, DetectableSize]
    hidden: tuple[NotTestable, ...]
    wanted: tuple[str, ...]
    separation: Separation | None
    predicted: Mapping[str, str]

    @property
    def rivals(self) -> tuple[str, ...]:
        """Explanations that it was chosen to tell apart; none without rivals."""
        return () if self.separation is None else self.separation.rivals
