"""Recordings and trajectories: references and signals over time, read and kept.

`reader.read_columns` reads a file of any format, and `recording.recording_of` makes the
`Recording` of its columns; `reference.step_reference` makes a step to be followed.
"""

from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.recordings.store.trial import Trial

__all__ = ["Recording", "SignalSpec", "Trajectory", "Trial", "step_reference"]
