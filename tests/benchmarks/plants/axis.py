"""The real axis of a benchmark study: a plant under friction and noise that differ by run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.sources.plants.failed_run import failed_run
from gmfbo.sources.twin.twin import FmuTwin
from tests.benchmarks.plants.catalogue import Plant
from tests.benchmarks.plants.truths.conditions import QUIET, Conditions, Fallen

FRICTION_SPREAD = 0.1
"""Largest change of the friction from run to run, as a share: uniform."""

_STREAM = 0xF71C7
"""Separates the draws of the plant from all others of the same seed."""


@dataclass(eq=False)
class PlantAxis:
    """Plays a plant; the n-th run is the same for all methods of a seed, but for its gains.

    Attributes
    ----------
    plant : Plant
        What is played.
    seed : int or None
        Of the study; None plays without noise.
    quiet : Conditions
        Of the runs without noise.
    """

    plant: Plant
    seed: int | None = None
    quiet: Conditions = QUIET
    runs: int = 0
    _fmus: FmuTwin | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.plant.check()

    @property
    def name(self) -> str:
        """Of the plant."""
        return self.plant.name

    @property
    def content_hash(self) -> str:
        """Empty: the study cannot be resumed, so that nothing need be compared."""
        return ""

    def run(self, gains: Mapping[str, float], reference: Recording) -> Recording:
        """Play one run; a plant that falls is a failed run."""
        conditions = self._conditions()
        self.runs += 1
        if self.plant.truth is None:
            return self._of_fmus(gains, reference, conditions)
        try:
            columns = dict(self.plant.truth(gains, reference, conditions))
        except Fallen as error:
            return failed_run(reference, str(error), name=self.name)
        time = np.asarray(columns.pop("time"))
        return Trajectory(time=time, signals=columns, name=self.name, parameters=dict(gains))

    def _conditions(self) -> Conditions:
        if self.seed is None:
            return self.quiet
        rng = np.random.default_rng([self.seed, _STREAM, self.runs])
        noise = self.plant.noise
        friction = 1.0 + noise * FRICTION_SPREAD * float(rng.uniform(-1.0, 1.0))
        return Conditions(friction, rng, level=noise)

    def _of_fmus(
        self, gains: Mapping[str, float], reference: Recording, conditions: Conditions
    ) -> Recording:
        """Noise comes from `[is1] noise` of the study file here."""
        if self._fmus is None:
            self._fmus = FmuTwin(self.plant.folder / "truth.toml", isolated=False)
        changed = {self.plant.friction: conditions.friction}
        if conditions.inertia != 1.0:
            name = self.plant.inertia
            changed[name] = conditions.inertia * self._fmus.nominal(name)
        return self._fmus.run(gains, reference, parameters=changed)

    def close(self) -> None:
        """End the FMUs."""
        if self._fmus is not None:
            self._fmus.close()
            self._fmus = None
