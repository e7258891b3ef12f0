"""What was asked and what was measured."""

from gmfbo.recordings.columns.signal import SignalSpec
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.reference import step_reference
from gmfbo.recordings.store.trial import Trial

__all__ = ["Recording", "SignalSpec", "Trajectory", "Trial", "step_reference"]
