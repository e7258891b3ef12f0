"""The objective of a study with its constants, from the initial twin runs or the study file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.errors import SimulationError
from gmfbo.objective.cost import Objective
from gmfbo.recordings.recording import Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study_file.study_sections import StudyFile


def objective_of(
    study: StudyFile, experiment: ExperimentSeries, initial: Sequence[Trial]
) -> Objective:
    """Objective with mean, spread and worst case of each metric.

    Parameters
    ----------
    study : StudyFile
        With weights, and constants or the number of runs that give them.
    experiment : ExperimentSeries
        Names the metrics, and the worst case of step metrics.
    initial : sequence of Trial
        The initial twin runs.

    Raises
    ------
    SimulationError
        All of them failed.
    """
    if all(trial.status != "ok" for trial in initial):
        first = initial[0].recording
        reason = first.message if isinstance(first, Trajectory) else ""
        raise SimulationError(
            f"none of the {len(initial)} initial runs of IS2 succeeded "
            f"({initial[0].status}: {reason}); run the twin alone with 'gmfbo simulate'"
        )
    section = study.objective
    sampled = [trial for trial in initial[: section.normalise.points] if trial.status == "ok"]
    names = (*experiment.metric_names, *sorted(study.own_metrics))
    constants = Objective.from_samples(
        section.weights,
        {
            name: np.array([trial.metrics[name] for trial in sampled])
            for name in names
            # Studies of former versions did not measure all that is known today.
            if all(name in trial.metrics for trial in sampled)
        },
        worst=experiment.worst,
    )
    if section.normalise.points is not None:
        return constants
    return Objective(
        section.weights, section.normalise.mean, section.normalise.std, constants.worst
    )
