"""Constants of the cost, from the initial runs of the twin or as the study file gives them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from gmfbo.errors import SimulationError
from gmfbo.objective.cost import Objective
from gmfbo.objective.metrics import METRICS
from gmfbo.recordings.recording import Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.study_file.study_sections import ObjectiveSection


def constants_of(
    initial: Sequence[Trial],
    section: ObjectiveSection,
    own_metrics: Collection[str],
    worst: Mapping[str, float],
) -> Objective:
    """The objective with its normalising constants.

    Parameters
    ----------
    initial : sequence of Trial
        Initial runs of the twin, with metrics; their costs may be missing.
    section : ObjectiveSection
        Part `[objective]` of the study file.
    own_metrics : collection of str
        Metrics by a function of the user.
    worst : mapping of str to float
        Step metrics of a failed run [% or s].

    Raises
    ------
    SimulationError
        All initial runs failed.
    """
    if all(trial.status != "ok" for trial in initial):
        first = initial[0].recording
        reason = first.message if isinstance(first, Trajectory) else ""
        raise SimulationError(
            f"none of the {len(initial)} initial runs of IS2 succeeded "
            f"({initial[0].status}: {reason}); run the twin alone with 'gmfbo simulate'"
        )
    sampled = [trial for trial in initial[: section.normalise.points] if trial.status == "ok"]
    constants = Objective.from_samples(
        section.weights,
        {
            name: np.array([trial.metrics[name] for trial in sampled])
            for name in (*METRICS, *sorted(own_metrics))
        },
        worst=worst,
    )
    if section.normalise.points is not None:
        return constants
    return Objective(
        section.weights, section.normalise.mean, section.normalise.std, constants.worst
    )
