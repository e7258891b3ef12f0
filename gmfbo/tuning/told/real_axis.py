"""The real axis: recordings that can be scored, or failed runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import InputError, RecordingError
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.reference import followed_signal
from gmfbo.sources.plants.failed_run import failed_run
from gmfbo.sources.plants.source import Source
from gmfbo.space import same_gain


@dataclass(frozen=True)
class RealAxis:
    """A plant whose recordings are checked against the request.

    Attributes
    ----------
    source : Source
        The plant.
    """

    source: Source

    @property
    def name(self) -> str:
        """Name of the plant."""
        return self.source.name

    @property
    def content_hash(self) -> str:
        """Content hash of the plant."""
        return self.source.content_hash

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Run the plant; an unreadable recording, or one at other gains, is a failed run."""
        try:
            run = self.source.run(gains, reference)
        except RecordingError as error:
            return failed_run(reference, str(error), name=self.name)
        for name, value in gains.items():
            used = run.parameters.get(name, value)
            if not same_gain(used, value):
                message = f"{self.name}: made with {name} = {used:g} instead of {value:g}"
                return failed_run(reference, message, name=self.name, left=run)
        return on_the_clock_of(reference, run)

    def close(self) -> None:
        """Close the plant."""
        self.source.close()


class Scoring(Protocol):
    """Anything that computes metrics of a run, and raises where it cannot be scored."""

    @property
    def reference(self) -> Recording: ...

    def metrics(self, run: Recording) -> Mapping[str, float]:
        """Metrics of a run."""
        ...


def scorable(run: Recording, experiment: Scoring) -> Recording:
    """Return a run; a run that lacks the signal or is too short becomes a failed one.

    A failed run never ends a study. A recording told by hand is refused instead.
    """
    try:
        experiment.metrics(run)
    except InputError as error:
        return failed_run(experiment.reference, str(error), name=run.name, left=run)
    return run


def on_the_clock_of(reference: Recording, run: Recording) -> Recording:
    """Shift a recording so that its reference changes when the requested one does.

    A logger's clock begins anywhere. A recording whose reference changes more or less often than
    the requested one is taken to be on its clock already.
    """
    signal = followed_signal(reference)
    asked, seen = _changes(reference, signal), _changes(run, signal)
    if asked.size == 0 or asked.size != seen.size:
        return run
    shift = float(asked[0] - seen[0])
    # A shift below one sample is the logger's rounding; simulated runs stay unchanged.
    if abs(shift) <= float(np.median(np.diff(run.time))):
        return run
    use = None if run.use is None else (run.use[0] + shift, run.use[1] + shift)
    return replace(run, time=run.time + shift, use=use)


def _changes(recording: Recording, signal: str) -> NDArray[np.float64]:
    """[s] When a signal changes, shape (c,); empty where it is absent."""
    values = recording.signals.get(signal)
    if values is None:
        return np.empty(0)
    sampled = np.flatnonzero(np.isfinite(values))
    return np.asarray(recording.time[sampled[np.flatnonzero(np.diff(values[sampled])) + 1]])
