"""An FMU that plays the real axis, with the measurement noise that an axis has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.query.initial_design import Stream, stream
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study_file.study_sections import StudyFile


@dataclass(frozen=True, eq=False)
class NoisyAxis:
    """Adds white noise to recorded signals of a source.

    The noise is in the recording alone: the controller inside the FMU does not see it. A run that
    failed keeps its signals as they are.

    Attributes
    ----------
    source : Source
        Plays the axis.
    deviations : mapping of str to float
        Standard deviation by signal [unit of the signal].
    rng : numpy.random.Generator
        Of this run; equal for equal seed and number of the run.
    """

    source: Source
    deviations: Mapping[str, float]
    rng: np.random.Generator

    @property
    def name(self) -> str:
        """Name of the source."""
        return self.source.name

    @property
    def content_hash(self) -> str:
        """Content hash of the source."""
        return self.source.content_hash

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Run the source, and add the noise."""
        run = self.source.run(gains, reference)
        # All are drawn, so that a signal that is missing does not change the others' noise.
        noise = {
            name: std * self.rng.standard_normal(len(run.time))
            for name, std in sorted(self.deviations.items())
        }
        signals = {name: values + noise.get(name, 0.0) for name, values in run.signals.items()}
        return replace(run, signals=signals)

    def close(self) -> None:
        """Leave the source to its owner."""


def next_axis(sources: StudySources, study: StudyFile, runs_before: int) -> Source:
    """Source of the next real run, with the noise that the study file gives it.

    Parameters
    ----------
    sources : StudySources
        With a real axis that can be run from here.
    study : StudyFile
        The validated file.
    runs_before : int
        Number of real runs so far, initial ones included.
    """
    plant = sources.real(runs_before)
    assert plant is not None
    if not study.is1.noise:
        return plant
    return NoisyAxis(plant, study.is1.noise, stream(study.seed, Stream.NOISE, runs_before))
