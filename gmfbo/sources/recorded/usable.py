"""Recordings as a twin may use them: unwrapped, and without contradiction to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.contradiction import Doubts, refuse_contradictions, scale_doubts
from gmfbo.sources.recorded.missing_signals import MissingSignal, missing_signals
from gmfbo.sources.recorded.wrapped_angle import unwrapped
from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True, eq=False)
class Usable:
    """Recordings to use, and what there is to tell about them.

    Attributes
    ----------
    recordings : tuple of Recording
        Without jumps of wrapped angles.
    notes : tuple of str
        What was changed in them, and what their reader took for granted.
    missing : tuple of MissingSignal
        Signals that are not compared.
    doubts : Doubts
        Recordings that the twin's controller has to judge.
    """

    recordings: tuple[Recording, ...]
    notes: tuple[str, ...]
    missing: tuple[MissingSignal, ...]
    doubts: Doubts


def usable(twin: FmuTwin, recordings: Sequence[Recording]) -> Usable:
    """Unwrap angles, name what is missing, and refuse recordings that contradict the twin.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    recordings : sequence of Recording
        As they were read.

    Raises
    ------
    RecordingError
        A recording contradicts the twin; one line says how.
    """
    whole, notes = whole_angles(twin, recordings)
    doubts = refuse_contradictions(twin, whole)
    notes = [note for recording in recordings for note in recording.notes] + notes
    notes += [doubt for recording in whole for doubt in scale_doubts(twin, recording)]
    return Usable(tuple(whole), tuple(notes), tuple(missing_signals(twin, whole)), doubts)


def whole_angles(
    twin: FmuTwin, recordings: Sequence[Recording]
) -> tuple[list[Recording], list[str]]:
    """Unwrap the angles of all recordings.

    Parameters
    ----------
    twin : FmuTwin
        Tells which signals are angles.
    recordings : sequence of Recording
        As they were read.

    Returns
    -------
    tuple of list of Recording and list of str
        The recordings, and what was changed in them.
    """
    changed = [unwrapped(recording, twin) for recording in recordings]
    return [recording for recording, _ in changed], [n for _, notes in changed for n in notes]
