"""How good gains really are: noise-free runs of a plant, and their cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.study.study_sources import StudySources
from gmfbo.tuning.study.study_terms import experiment_of
from gmfbo.tuning.study_file.gain_choice import GainChoice
from tests.benchmarks.plants.axis import PlantAxis
from tests.benchmarks.plants.catalogue import Plant
from tests.benchmarks.plants.truths.conditions import QUIET, Conditions


@dataclass(eq=False)
class Judge:
    """Plays a plant at mean friction and without noise; a context manager.

    Attributes
    ----------
    plant : Plant
        What is played.
    study : Study
        Its study.
    sources : StudySources
        Opened for the twin's box; its axis is not run.
    gains : GainChoice
        Tuned and held gains.
    experiment : ExperimentSeries
        References and metrics.
    axis : PlantAxis
        The plant without noise.
    """

    plant: Plant
    study: Study
    sources: StudySources
    gains: GainChoice
    experiment: ExperimentSeries
    axis: PlantAxis

    @classmethod
    def open(cls, plant: Plant, study: Study | None = None, quiet: Conditions = QUIET) -> Self:
        """Open a plant's study.

        Parameters
        ----------
        plant : Plant
            One of the catalogue.
        study : Study, optional
            In place of its own.
        quiet : Conditions
            Friction and inertia of all runs.
        """
        study = study or plant.study()
        axis = PlantAxis(plant, quiet=quiet)
        sources = StudySources.open(study.file, study.origin, is1=axis)
        gains = GainChoice.combine(sources.gains, study.file.gains, sources.parameters)
        experiment = experiment_of(study, sources, None)
        return cls(plant, study, sources, gains, experiment, axis)

    @property
    def in_force(self) -> NDArray[np.float64]:
        """Gains before tuning, shape (d,) [unit of each]."""
        ranges = self.study.file.gains
        return np.array([float(ranges[name].now or 0.0) for name in self.gains.space.names])

    def run(self, point: NDArray[np.float64]) -> Recording:
        """Noise-free run at gains, shape (d,) [unit of each]."""
        return play(self.axis, self.gains.values(point), self.experiment)

    def weighed(self, point: NDArray[np.float64]) -> dict[str, float]:
        """Weighted metrics and late error at gains (d,); infinite where the run failed."""
        run = self.run(point)
        late = self.experiment.late_error(run)
        if not np.isfinite(late):
            return {**dict.fromkeys(self.weights, np.inf), "late_error": np.inf}
        metrics = self.experiment.metrics(run)
        return {**{name: metrics[name] for name in self.weights}, "late_error": late}

    @property
    def weights(self) -> Mapping[str, float]:
        """Weight of each metric."""
        return self.study.file.objective.weights

    def cost(self, weighed: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Cost g by the study's constants; infinite where a run did not settle.

        Parameters
        ----------
        weighed : mapping of str to ndarray
            Each weighted metric and the late error, of equal shape.
        """
        constants = self.study.file.objective.normalise
        total = np.zeros(np.shape(weighed["late_error"]))
        for name, weight in self.weights.items():
            scaled = (np.asarray(weighed[name]) - constants.mean[name]) / constants.std[name]
            total = total + weight * scaled
        return np.asarray(np.where(np.asarray(weighed["late_error"]) <= 1.0, total, np.inf))

    def true_cost(self, point: NDArray[np.float64]) -> float:
        """Noise-free cost g at gains (d,); infinite where the run failed or did not settle."""
        weighed = {name: np.asarray(value) for name, value in self.weighed(point).items()}
        return float(self.cost(weighed))

    def close(self) -> None:
        """End all FMUs."""
        self.sources.close()
        self.axis.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
