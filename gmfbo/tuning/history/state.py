"""What a method may know when it proposes: all that was observed so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.recordings.store.trial import SourceName, Trial
from gmfbo.space import GainSpace
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.history.keep_out import KeepOut


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
    limited : mapping of str to float
        Each limited metric, the largest over the references [unit of the metric].
    feasible : bool
        The run succeeded and meets all limits.
    outdated : float
        Variance of the change of the plant since this run, over the variance of the costs of the
        real runs; 0 where it has not changed.
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
    limited: Mapping[str, float] = field(default_factory=dict)
    feasible: bool = True
    outdated: float = 0.0


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
    experiment : ExperimentSeries
        What every source repeats.
    objective : Objective
        From metrics to cost.
    limits : Limits
        On metrics.
    keep_out : KeepOut
        Gains that the real axis must not be run at.
    """

    space: GainSpace
    observations: tuple[Observation, ...]
    fixed: Mapping[str, float]
    trials: tuple[Trial, ...]
    experiment: ExperimentSeries
    objective: Objective
    limits: Limits = field(default_factory=Limits)
    keep_out: KeepOut = field(default_factory=KeepOut)

    def incumbent(self, *sources: SourceName) -> float:
        """Least cost g of runs that meet the limits, the bar of an improvement.

        Runs from before a change of the plant are no bar.

        While there is none, any run that meets the limits improves on a failed one: then the
        bar is its price. Without limits a failed run counts with that price, too.

        Parameters
        ----------
        *sources : str
            Of the runs; `IS1` unless given.
        """
        wanted = self.of(*(sources or ("IS1",)))
        seen = [one for one in wanted if not one.outdated] or wanted
        if not self.limits:
            return min(one.objective for one in seen)
        return min((one.objective for one in seen if one.feasible), default=self.objective.failed)

    def of(self, *sources: SourceName) -> tuple[Observation, ...]:
        """Observations of some sources, in order.

        Parameters
        ----------
        *sources : {"IS1", "IS2", "IS3"}
            Who ran.
        """
        return tuple(seen for seen in self.observations if seen.source in sources)

    def extra_of(self, seen: Sequence[Observation], values: NDArray[np.float64]) -> list[float]:
        """Noise variance that runs get because the plant has changed since.

        Parameters
        ----------
        seen : sequence of Observation
            Runs of any source, n of them.
        values : ndarray, shape (n,)
            What is modelled, such as the cost.

        Returns
        -------
        list of float, length n
            [unit of the values squared]
        """
        real = values[[one.source == "IS1" for one in seen]]
        spread = float(np.var(real)) if len(real) else 0.0
        return [one.outdated * spread for one in seen]

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
        """Copy of points of the unit cube, shape (..., d), with the held gains put in.

        Parameters
        ----------
        unit : ndarray, shape (..., d)
            Points; unchanged themselves.
        """
        held = np.array(unit, dtype=float)
        for column, value in self.fixed_unit.items():
            held[..., column] = value
        return held
