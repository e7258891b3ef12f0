"""From trials to the observations that a surrogate sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.cost import Objective
from gmfbo.objective.limits import Limits
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.drift.drift import Drift
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.history.state import Observation


def observed(
    trial: Trial,
    point: NDArray[np.float64],
    experiment: ExperimentSeries,
    objective: Objective,
    limits: Limits,
) -> Observation:
    """A trial as the surrogate sees it.

    Parameters
    ----------
    trial : Trial
        With its cost.
    point : ndarray, shape (d,)
        Its gains in the unit cube.
    experiment : ExperimentSeries
        Experiment of every source.
    objective : Objective
        From metrics to cost.
    limits : Limits
        On metrics.
    """
    uncorrected = uncorrected_scaled = None
    if trial.source == "IS3":
        before = trial.uncorrected[experiment.signal]
        metrics = experiment.metrics_of(trial.recording.time, before)
        uncorrected = float(objective.value(metrics))
        uncorrected_scaled = float(objective.scaled(metrics))
    return Observation(
        number=trial.number,
        source=trial.source,
        point=point,
        objective=trial.objective,
        scaled=float(objective.scaled(trial.metrics)),
        failed=trial.status != "ok",
        parent=trial.parent,
        uncorrected=uncorrected,
        uncorrected_scaled=uncorrected_scaled,
        limited={n: float(v) for n, v in limits.limited(trial.metrics).items()},
        feasible=trial.status == "ok" and limits.met(trial.metrics),
        late_error=0.0 if trial.late_error is None else trial.late_error,
    )


def aged(observations: tuple[Observation, ...], drifts: Sequence[Drift]) -> tuple[Observation, ...]:
    """Mark observations by the axis, or corrected by it, from before the plant changed.

    A run before several changes is marked with the sum of them.

    Parameters
    ----------
    observations : tuple of Observation
        Of all sources.
    drifts : sequence of Drift
        Detected changes of the plant, in order.
    """
    if not drifts:
        return observations
    marked = []
    for seen in observations:
        origin = seen.number if seen.source == "IS1" else seen.parent
        shares = [
            drift.share
            for drift in drifts
            if seen.source != "IS2" and origin is not None and origin <= drift.last_before
        ]
        marked.append(replace(seen, outdated=sum(shares)) if shares else seen)
    return tuple(marked)
