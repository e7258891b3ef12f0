"""Optimise the gains on the twin as it is now, run them, and then improve on what it misses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import least_expected_tried
from gmfbo.tuning.methods.twin_rows import cost_of_rows, sample_times, twin_runs
from gmfbo.tuning.query.method import Proposal
from gmfbo.tuning.twin.runs_beside import runs_beside

Vector = NDArray[np.float64]

RUN_RADIUS = 0.005
"""Distance in the unit cube within which gains count as run: a fifth of a step of a grid of 41."""


def twin_costs(state: TuningState) -> tuple[Vector, Vector]:
    """Points (q, d) at which the twin ran, and its cost g, shape (q,); infinite if unsettled."""
    times = sample_times(state)
    points, rows = twin_runs(state, times)
    if not len(points):
        return points, np.empty(0)
    cost = np.array(cost_of_rows(state, times)(rows))
    cost[state.late_error_of(times, rows[:, : times.size]) > 1.0] = np.inf
    return points, cost


def optimum_of_twin(state: TuningState) -> Vector | None:
    """Gains of the twin's least cost, shape (d,); None where it settles nowhere."""
    points, cost = twin_costs(state)
    if not np.isfinite(cost).any():
        return None
    best: Vector = points[int(np.argmin(cost))]
    return best


def at_optimum_or_beyond(state: TuningState) -> Proposal | None:
    """Ask the axis at the twin's optimum; once run there, where it may still be improved on.

    Parameters
    ----------
    state : TuningState
        With a finished real run.

    Returns
    -------
    Proposal or None
        None where the twin settles nowhere.
    """
    points, cost = twin_costs(state)
    if not np.isfinite(cost).any():
        return None
    best = _allowed(state, points[[int(np.argmin(cost))]])[0]
    run = np.stack([one.point for one in state.of("IS1")])
    if np.abs(run - best).max(axis=1).min() > RUN_RADIUS:
        return Proposal("IS1", best, note="optimum of the model")
    distance = np.abs(points[:, None, :] - run).max(axis=2).min(axis=1)
    open_ = np.isfinite(cost) & (distance > RUN_RADIUS) & state.keep_out.admitted(points)
    if not open_.any():
        return Proposal("IS1", best, note="optimum of the model")
    return _beyond(state, points[open_], cost[open_])


def _beyond(state: TuningState, points: Vector, cost: Vector) -> Proposal:
    """Expected improvement where the model is right but for a smooth function of the gains."""
    from gmfbo.acquisition.improvement import log_improvement
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings
    from gmfbo.surrogate.observations import Observations

    twins = {trial.number: trial for trial in state.trials if trial.source == "IS2"}
    beside = {n: twins[t.number].objective for n, t in runs_beside(state.trials).items()}
    real = [one for one in state.of("IS1") if one.counts]
    left = [one.objective - beside.get(one.number, float(np.max(cost))) for one in real]
    rows = [(one.point, "IS1", value) for one, value in zip(real, left, strict=True)]
    process = SourceModel.fit(Observations.gather(rows), SurrogateSettings(ard=True))
    mean, variance = process.predict(points, "IS1")

    def predict(at: Vector, source: str) -> tuple[Vector, Vector]:
        model = [one.objective - value for one, value in zip(real, left, strict=True)]
        known = np.array([one.point for one in real])
        same = np.argmin(((at[:, None, :] - known) ** 2).sum(axis=2), axis=1)
        beyond, spread = process.predict(at, "IS1")
        return np.array(model)[same] + beyond, spread

    _, incumbent, _ = least_expected_tried(predict, state)
    row = int(np.argmax(log_improvement(cost + mean, variance, incumbent)))
    expected = float(cost[row] + mean[row]), float(np.sqrt(variance[row]))
    return Proposal("IS1", points[row], note="beyond the model", expected=expected)


def _allowed(state: TuningState, points: Vector) -> Vector:
    """The points, each moved to where the axis may be run."""
    held, moves = state.hold(points), state.keep_out.moves
    if moves is not None:
        held = state.hold(moves.nearest(held))
    return np.asarray(state.space.to_unit(state.space.from_unit(held)))
