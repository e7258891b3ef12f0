"""What a further real run is worth: the gain that is expected of it, and the noise of one run."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from gmfbo.objective.smoothing import smoothed
from gmfbo.tuning.history.state import TuningState

CONFIRMATIONS = 2
"""Last runs that may repeat the recommended gains: with one repetition alone, an unlucky run and a
lucky one before cannot be told apart."""

DRAWS = 64
"""Draws of a run's measurement noise; the deviation of its cost is then known to about 9 %."""

CALMED = 3.0
"""Time constant, in samples, of the low-pass that takes a run's own noise off before it is drawn
anew: it leaves a third of white noise, and of a response what lasts more than some samples."""

MOST_RUNS = 4
"""Newest settled runs whose noise is drawn; later ones lie near the best gains."""


def expected_gain(expected: tuple[float, float], incumbent: float) -> float:
    """Expected improvement [g] of a run over an incumbent cost.

    Parameters
    ----------
    expected : tuple of float
        Predicted cost [g] and its standard deviation.
    incumbent : float
        [g] Expected cost of the recommended gains.
    """
    mean, std = expected
    if std <= 0.0:
        return max(incumbent - mean, 0.0)
    u = (incumbent - mean) / std
    return float(std * (norm.pdf(u) + u * norm.cdf(u)))


def noise_of_one_run(state: TuningState) -> float:
    """Standard deviation [g] by which the cost of a run differs from that of its repetition.

    What the measurement noise of a run does to its cost is found by drawing that noise anew. It
    knows nothing of friction that changes from run to run, which settled runs at equal gains show:
    both variances are pooled, the first with as many degrees of freedom as runs were drawn, and the
    result is no less than the first.

    Parameters
    ----------
    state : TuningState
        What was observed.
    """
    measured, runs = _by_measurement(state)
    squares, freedom = _among_repeats(state)
    if runs + freedom == 0:
        return 0.0
    pooled = np.sqrt((runs * measured**2 + squares) / (runs + freedom))
    return float(max(measured, pooled))


def _among_repeats(state: TuningState) -> tuple[float, int]:
    """Squares about the means of settled runs at equal gains, and their degrees of freedom."""
    costs: dict[tuple[float, ...], list[float]] = {}
    for one in state.of("IS1"):
        if one.counts and not one.outdated:
            costs.setdefault(tuple(np.round(one.point, 6)), []).append(one.objective)
    groups = [np.array(values) for values in costs.values() if len(values) > 1]
    squares = sum(float(np.sum((values - values.mean()) ** 2)) for values in groups)
    return squares, sum(len(values) - 1 for values in groups)


def _by_measurement(state: TuningState) -> tuple[float, int]:
    """What measurement noise does to the cost, median over the newest settled runs; their count."""
    counted = {one.number for one in state.of("IS1") if one.counts and not one.outdated}
    signal, found = state.experiment.signal, []
    for trial in [one for one in state.trials if one.number in counted][-MOST_RUNS:]:
        run = trial.recording
        if trial.bare:
            continue
        sampled = np.isfinite(run.signal(signal))
        times, values = run.time[sampled], run.signal(signal)[sampled]
        noise = state.experiment.noise(run)
        draws = np.random.default_rng(trial.number).standard_normal((DRAWS, times.size))
        # Drawn on top of the noise that is there, it would count double.
        calm = smoothed(times, values, CALMED * float(np.median(np.diff(times))))
        drawn = state.experiment.metrics_of(times, calm + noise * draws)
        # Metrics of other signals are not drawn, and keep their value.
        metrics = {
            name: np.where(np.isnan(drawn[name]), value, drawn[name]) if name in drawn else value
            for name, value in trial.metrics.items()
        }
        found.append(float(np.std(state.objective.value(metrics))))
    return (float(np.median(found)) if found else 0.0), len(found)
