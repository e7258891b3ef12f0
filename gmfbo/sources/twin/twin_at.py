"""A twin at other values of its parameters, as an information source."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True, eq=False)
class TwinAt:
    """Runs a twin of another owner at fixed values; closing leaves the twin open.

    Attributes
    ----------
    twin : FmuTwin
        The twin.
    values : mapping of str to float
        [FMU's unit] Over the twin's own parameters.
    draw : callable or None
        Draws other values from what is believed about them; None where they are certain.
    """

    twin: FmuTwin
    values: Mapping[str, float]
    draw: Callable[[np.random.Generator], Mapping[str, float]] | None = None

    @property
    def name(self) -> str:
        """Name of the twin."""
        return self.twin.name

    @property
    def content_hash(self) -> str:
        """SHA-256 of the twin's hash and the values."""
        text = json.dumps([self.twin.content_hash, dict(self.values)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def run(self, gains: Mapping[str, float], reference: Recording) -> Trajectory:
        """Simulate the twin at these gains."""
        return self.twin.run(gains, reference, parameters=self.values)

    def believed(self, rng: np.random.Generator) -> TwinAt:
        """The twin at values drawn from what is believed about them.

        Parameters
        ----------
        rng : numpy.random.Generator
            Source of randomness.
        """
        return self if self.draw is None else TwinAt(self.twin, self.draw(rng))

    def close(self) -> None:
        """Leave the twin to its owner."""
