"""Tuning state: all observations that a method may use to propose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.objective.settled import short_of_settling
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
        Whether the run failed, and has the cost of a failed run.
    parent : int or None
        IS1 trial that caused an IS2 run, or around which an IS3 sample was drawn.
    uncorrected, uncorrected_scaled : float or None
        IS3: g and G of the twin's trajectory before correction.
    limited : mapping of str to float
        Largest value over the references of each limited metric [unit of the metric].
    feasible : bool
        Whether the run succeeded and meets all limits.
    late_error : float
        Late error over what counts as settled, at most 1 where the run settled.
    counts : bool
        Whether its cost is modelled: False for runs of a lower rank than the best real run.
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
    late_error: float = 0.0
    counts: bool = True

    @property
    def settled(self) -> bool:
        """Whether the run ended well, inside the envelope, and settled."""
        return not self.failed and self.late_error <= 1.0


@dataclass(frozen=True, eq=False)
class TuningState:
    """All values that a proposal may depend on.

    Attributes
    ----------
    space : GainSpace
        Box of the tuned gains.
    observations : tuple of Observation
        In the order in which they were made.
    fixed : mapping of str to float
        Gains to be held at a value in this proposal.
    trials : tuple of Trial
        The runs themselves, for methods that use trajectories.
    experiment : ExperimentSeries
        Experiment of every source.
    objective : Objective
        From metrics to cost.
    limits : Limits
        On metrics.
    keep_out : KeepOut
        Gains that the real axis must not be run at.
    ranked : bool
        Whether runs are ranked before their cost counts; otherwise a failed run has a price.
    """

    space: GainSpace
    observations: tuple[Observation, ...]
    fixed: Mapping[str, float]
    trials: tuple[Trial, ...]
    experiment: ExperimentSeries
    objective: Objective
    limits: Limits = field(default_factory=Limits)
    keep_out: KeepOut = field(default_factory=KeepOut)
    ranked: bool = False

    def incumbent(self, *sources: SourceName) -> float:
        """Incumbent: least cost g of runs that meet the limits.

        Runs from before a change of the plant do not count.

        While no run meets the limits, the cost of a failed run serves as incumbent. Without
        limits, a failed run counts with that cost too.

        Parameters
        ----------
        *sources : str
            Sources of the runs; `IS1` unless given.
        """
        wanted = [one for one in self.of(*(sources or ("IS1",))) if one.counts]
        seen = [one for one in wanted if not one.outdated] or wanted
        if not self.limits or self.unsettled:
            return min((one.objective for one in seen), default=self.objective.failed)
        return min((one.objective for one in seen if one.feasible), default=self.objective.failed)

    @property
    def unsettled(self) -> bool:
        """Whether no real run has settled yet, so that the cost is how far runs are from it."""
        real = self.of("IS1")
        return self.ranked and bool(real) and not any(seen.settled for seen in real)

    def cost_of(
        self,
        times: NDArray[np.float64],
        trajectories: NDArray[np.float64],
        numbers: Mapping[str, NDArray[np.float64]] | None = None,
    ) -> NDArray[np.float64]:
        """Cost of bare trajectories, as that of the observations, shape (q,).

        Parameters
        ----------
        times : ndarray, shape (m,)
            [s] See `ExperimentSeries.scored_times`.
        trajectories : ndarray, shape (q, m)
            The scored signal.
        numbers : mapping of str to ndarray, shape (q,), optional
            Metrics that do not follow from it, as far as they are known.
        """
        if self.unsettled:
            return short_of_settling(self.late_error_of(times, trajectories))
        metrics = self.experiment.metrics_of(times, trajectories, self.objective.weights)
        return self.objective.value({**metrics, **(numbers or {})})

    def late_error_of(
        self, times: NDArray[np.float64], trajectories: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Late error of bare trajectories, corrected by real runs, shape (q,).

        They carry the noise of these runs, which is allowed for as in them.

        Parameters
        ----------
        times : ndarray, shape (m,)
            [s] See `ExperimentSeries.scored_times`.
        trajectories : ndarray, shape (q, m)
            The scored signal.
        """
        real = [one for one in self.trials if one.source == "IS1" and one.status == "ok"]
        measured = (self.experiment.noise(one.recording) for one in real if not one.bare)
        noise = max(measured, default=0.0)
        return self.experiment.late_error_of(times, trajectories, noise)

    def of(self, *sources: SourceName) -> tuple[Observation, ...]:
        """Observations of some sources, in order.

        Parameters
        ----------
        *sources : {"IS1", "IS2", "IS3"}
            Sources of the runs.
        """
        return tuple(seen for seen in self.observations if seen.source in sources)

    def extra_of(self, seen: Sequence[Observation], values: NDArray[np.float64]) -> list[float]:
        """Extra noise variance of runs made before a change of the plant.

        Parameters
        ----------
        seen : sequence of Observation
            Runs of any source, n of them.
        values : ndarray, shape (n,)
            Modelled values, such as the cost.

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
        """Copy of points of the unit cube, shape (..., d), with the held gains set.

        Parameters
        ----------
        unit : ndarray, shape (..., d)
            Points; unchanged themselves.
        """
        held = np.array(unit, dtype=float)
        for column, value in self.fixed_unit.items():
            held[..., column] = value
        return held
