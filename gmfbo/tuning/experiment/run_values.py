"""Values of a real run in which a change of the plant shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries

MOST_SAMPLES = 400
"""Most compared samples of a trajectory."""


@dataclass(frozen=True, eq=False)
class RunValues:
    """One kind of value, of each real run that has it.

    Attributes
    ----------
    name : str
        Name for the user.
    rows : ndarray of int, shape (n,)
        Places of these runs among all real runs, increasing.
    values : ndarray, shape (n,)
        The value.
    """

    name: str
    rows: NDArray[np.int_]
    values: NDArray[np.float64]


def values_of_runs(
    real: Sequence[Trial], beside: Sequence[Trial | None], experiment: ExperimentSeries
) -> list[RunValues]:
    """Mean, spread and error of the scored signal, and its difference from the twin's.

    These values vary smoothly with the gains; the cost jumps where a response just enters the
    settling band, which looks like a change. The error is weighted by the time since the step,
    as in ITAE (Graham and Lathrop 1953), and its logarithm taken, since gains change it by
    factors. The lag of y behind the twin's x is the time shift that explains most of the
    difference, sum((x - y) x') / sum(x'^2). The mean difference from the twin shows a force that
    came or went. Differences from the twin hardly depend on the gains.

    Parameters
    ----------
    real : sequence of Trial
        Real runs in order; those that ended early, and rows of a table, have no values.
    beside : sequence of Trial or None
        The twin's run at the same gains, where there is one.
    experiment : ExperimentSeries
        Names the scored signal and the times.
    """
    times, signal = experiment.scored_times(MOST_SAMPLES), experiment.signal
    since, target = experiment.after_step(MOST_SAMPLES)
    found: dict[str, list[tuple[int, float]]] = {}
    for row, (trial, twin) in enumerate(zip(real, beside, strict=True)):
        if trial.status != "ok" or trial.bare:
            continue
        measured = sampled(trial, times, signal)
        values = {f"mean {signal}": float(measured.mean())}
        values[f"spread of {signal}"] = float(measured.std())
        late = float(np.mean(since * np.abs(measured - target)))
        values["lasting error"] = np.log(max(late, np.finfo(float).tiny))
        if twin is not None and twin.status == "ok":
            values["lag behind the twin"] = _lag(times, sampled(twin, times, signal), measured)
            for name in _answers(trial, twin, experiment):
                beyond = _mean(trial, times, name) - _mean(twin, times, name)
                values[f"mean {name} beyond the twin"] = beyond
        for name, value in values.items():
            found.setdefault(name, []).append((row, value))
    return [
        RunValues(name, np.array([r for r, _ in pairs], dtype=int), np.array([v for _, v in pairs]))
        for name, pairs in found.items()
    ]


def sampled(trial: Trial, times: NDArray[np.float64], signal: str) -> NDArray[np.float64]:
    """A signal of a run at given times, shape (m,)."""
    return at_times(trial.recording, trial.recording.signal(signal), times)


def at_times(
    recording: Recording, values: NDArray[np.float64], times: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Interpolate a recording's values at given times, shape (m,), without rows of NaN."""
    known = np.isfinite(values)
    return np.interp(times, recording.time[known], values[known])


def _mean(trial: Trial, times: NDArray[np.float64], signal: str) -> float:
    return float(sampled(trial, times, signal).mean())


def _answers(trial: Trial, twin: Trial, experiment: ExperimentSeries) -> list[str]:
    """Measured signals that both runs hold, sampled often enough to be compared."""
    played = {name for reference in experiment.references for name in reference.signals}
    one, other = trial.recording.signals, twin.recording.signals
    return sorted(
        name
        for name in (one.keys() & other.keys()) - played
        if min(np.isfinite(one[name]).sum(), np.isfinite(other[name]).sum()) >= 2
    )


def _lag(
    times: NDArray[np.float64], twin: NDArray[np.float64], measured: NDArray[np.float64]
) -> float:
    """[s] Lag of a run behind the twin; 0 where the twin does not move."""
    speed = np.gradient(twin, times)
    power = float(speed @ speed)
    return float((twin - measured) @ speed) / power if power > 0.0 else 0.0
