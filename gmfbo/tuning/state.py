"""What a method may know when it proposes: all that was observed so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.cost import Objective
from gmfbo.recordings.trial import SourceName, Trial
from gmfbo.space import GainSpace
from gmfbo.tuning.experiment import StepExperiment


@dataclass(frozen=True, eq=False)
class Observation:
    """One run as the surrogate sees it.

    Attributes
    ----------
    number : int
        Of the trial.
    source : {"IS1", "IS2", "IS3"}
        Real axis, twin, corrected twin.
    point : ndarray, shape (d,)
        Gains scaled to the unit cube.
    objective : float
        g, to be minimised.
    scaled : float
        G, without the mean subtracted, zero or more.
    failed : bool
        The run failed and carries the price of one.
    parent : int or None
        IS1 trial beside which an IS2 run was made, or about which an IS3 sample was drawn.
    uncorrected, uncorrected_scaled : float or None
        IS3: g and G of the twin's trajectory before correction.
    """

    number: int
    source: SourceName
    point: NDArray[np.float64]
    objective: float
    scaled: float
    failed: bool = False
    parent: int | None = None
    uncorrected: float | None = None
    uncorrected_scaled: float | None = None


@dataclass(frozen=True, eq=False)
class TuningState:
    """Everything that a proposal may depend on.

    Attributes
    ----------
    space : GainSpace
        Box of the tuned gains.
    observations : tuple of Observation
        In the order in which they were made.
    fixed : mapping of str to float
        Gains to be held at a value in this proposal.
    trials : tuple of Trial
        The runs themselves, for methods that look at trajectories.
    experiment : StepExperiment
        What every source repeats.
    objective : Objective
        From metrics to cost.
    """

    space: GainSpace
    observations: tuple[Observation, ...]
    fixed: Mapping[str, float]
    trials: tuple[Trial, ...]
    experiment: StepExperiment
    objective: Objective

    def of(self, *sources: SourceName) -> tuple[Observation, ...]:
        """Observations of some sources, in order."""
        return tuple(seen for seen in self.observations if seen.source in sources)

    @property
    def fixed_unit(self) -> dict[int, float]:
        """Column of each held gain, and its value scaled to [0, 1]."""
        if not self.fixed:
            return {}
        middle = self.space.named(self.space.from_unit(np.full(len(self.space), 0.5)))
        unit = self.space.to_unit(self.space.point({**middle, **self.fixed}))
        return {
            self.space.names.index(name): float(unit[self.space.names.index(name)])
            for name in self.fixed
        }

    def hold(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """Copy of points of the unit cube, shape (..., d), with the held gains put in."""
        held = np.array(unit, dtype=float)
        for column, value in self.fixed_unit.items():
            held[..., column] = value
        return held
