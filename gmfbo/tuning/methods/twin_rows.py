"""Rows that the corrected twin is fitted to: trajectories, and metrics that lie beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.metrics import METRICS
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.experiment.run_values import at_times
from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.twin.runs_beside import runs_beside

if TYPE_CHECKING:
    from gmfbo.surrogate.axis_residual import AxisRuns, CostOf

MOST_SAMPLES = 400
"""Samples of a trajectory that are compared; metrics interpolate between them."""

_ROWS: WeakKeyDictionary[Trial, tuple[Any, NDArray[np.float64]]] = WeakKeyDictionary()
"""Row of each trial, since a study reads those of a thousand twin runs several times a query."""


def sample_times(state: TuningState) -> NDArray[np.float64]:
    """Times at which trajectories are compared [s], shape (m,)."""
    return state.experiment.scored_times(MOST_SAMPLES)


def axis_runs(state: TuningState, times: NDArray[np.float64]) -> tuple[AxisRuns, CostOf]:
    """All real runs with the twin's beside them, and the cost of a trajectory.

    Parameters
    ----------
    state : TuningState
        With at least one real run.
    times : ndarray, shape (m,)
        [s] See `sample_times`.
    """
    from gmfbo.surrogate.axis_residual import AxisRuns

    twins = runs_beside(state.trials)
    modelled = modelled_runs(state)
    real, names = [trial for trial, _ in modelled], numbers_beside(state, times)
    runs = AxisRuns(
        points=np.stack([unit_point(state, trial) for trial in real]),
        values=np.array([seen.objective for _, seen in modelled]),
        simulated=np.stack([_row(state, twins.get(trial.number), times, names) for trial in real]),
        measured=np.stack([_row(state, trial, times, names) for trial in real]),
        extra=np.array([seen.outdated for _, seen in modelled]),
        beside=len(names),
    )
    return runs, cost_of_rows(state, times)


def numbers_beside(state: TuningState, times: NDArray[np.float64]) -> tuple[str, ...]:
    """Weighted metrics that do not follow from the scored signal, such as those of the command.

    The twin computes them for each of its runs, and real runs show by how much it errs.

    Parameters
    ----------
    state : TuningState
        What was observed.
    times : ndarray, shape (m,)
        [s] See `sample_times`.
    """
    if state.unsettled:  # the cost is how far runs are from settling
        return ()
    weighed = [name for name in state.objective.weights if name not in METRICS]
    sampled = (one for one in state.trials if one.status == "ok" and not one.bare)
    run = next(sampled, None) if weighed else None
    if run is None:
        return ()
    found = state.experiment.metrics_of(times, _sampled(run, times, state.experiment.signal))
    unknown = [name for name in weighed if np.isnan(found.get(name, np.nan))]
    # A recording without the command has none of its metrics, which then count as their mean.
    real = [one for one in state.trials if one.source == "IS1" and one.status == "ok"]
    return tuple(n for n in unknown if not any(np.isnan(one.metrics[n]) for one in real))


def cost_of_rows(state: TuningState, times: NDArray[np.float64]) -> CostOf:
    """Cost of rows as those of `twin_runs`, (q, m + p) to (q,)."""
    names = numbers_beside(state, times)

    def cost_of(rows: NDArray[np.float64]) -> NDArray[np.float64]:
        numbers = dict(zip(names, rows[:, times.size :].T, strict=True))
        return state.cost_of(times, rows[:, : times.size], numbers)

    return cost_of


def modelled_runs(state: TuningState) -> list[tuple[Trial, Observation]]:
    """Real runs that the corrected twin learns from, with their observations.

    Where runs are ranked, a run that failed has no cost and is left out. One that is bounded but
    did not settle shows the error of the twin as well as a settled one does.
    """
    seen = {one.number: one for one in state.of("IS1")}
    real = [(trial, seen[trial.number]) for trial in state.trials if trial.source == "IS1"]
    return [(trial, one) for trial, one in real if not (state.ranked and one.failed)]


def twin_runs(
    state: TuningState, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (q, d) and rows (q, m + p) of all that the twin was run for, IS3 included.

    A row is the trajectory at m times, and the p metrics of `numbers_beside`.
    """
    names = numbers_beside(state, times)
    made = [one for one in state.trials if one.source != "IS1" and one.status == "ok"]
    if not made:
        return np.empty((0, len(state.space))), np.empty((0, times.size + len(names)))
    known = {one.number: one.point for one in state.observations}
    points = [known[one.number] if one.number in known else unit_point(state, one) for one in made]
    return np.stack(points), np.stack([_row(state, trial, times, names) for trial in made])


def _row(
    state: TuningState,
    trial: Trial | None,
    times: NDArray[np.float64],
    names: Sequence[str],
) -> NDArray[np.float64]:
    """Samples and numbers of a run, as of the twin before any correction; NaN if it failed."""
    signal = state.experiment.signal
    if trial is None:
        return np.full(times.size + len(names), np.nan)
    known, key = _ROWS.get(trial), (signal, tuple(names), times.size, float(times[-1]))
    if known is not None and known[0] == key:
        return known[1]
    samples = _sampled(trial, times, signal, trial.uncorrected.get(signal))
    row = np.concatenate([samples, [trial.metrics[name] for name in names]])
    _ROWS[trial] = key, row
    return row


def _sampled(
    trial: Trial | None,
    times: NDArray[np.float64],
    signal: str,
    values: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """The signal of a run, or other values, at given times, shape (m,); NaN if it is unknown."""
    if trial is None or trial.status != "ok" or trial.bare:
        return np.full(times.size, np.nan)
    recording = trial.recording
    return at_times(recording, recording.signal(signal) if values is None else values, times)


def unit_point(state: TuningState, trial: Trial) -> NDArray[np.float64]:
    """Gains of a run in the unit cube, shape (d,)."""
    return state.space.to_unit([trial.gains[name] for name in state.space.names])
