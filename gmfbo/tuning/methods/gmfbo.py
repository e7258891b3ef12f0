"""The twin corrected at the level of trajectories, and improvement judged through the metrics.

The real trajectory is the twin's plus a residual that changes smoothly with the gains. Wherever
the twin was run, that is a belief about the real trajectory, and through the metrics about the
cost; the real axis is asked where the expected improvement is largest. The twin is cheap, so it
is run over the whole box once, and around each real run for the corrected runs (IS3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.trial import Trial
from gmfbo.tuning.method import CorrectionOptions, Proposal
from gmfbo.tuning.methods.beliefs import corrected_and_twin
from gmfbo.tuning.state import TuningState

SURVEY = 400
"""Runs of the twin over the box; a region of one percent of two gains then holds about four."""

MOST_SAMPLES = 400
"""Samples of a trajectory that the belief is about; metrics interpolate between them."""

LENGTHSCALES = (0.4, 0.8)
"""Of the residual over the unit cube, equally believed: a handful of real runs cannot tell."""

DRAWS = 16
"""Draws of the real trajectory at each point for each lengthscale."""

REPEAT_RADIUS, FAILED_RADIUS = 0.002, 0.05
"""Distances in the unit cube that are kept from real runs, and from those that failed."""


@dataclass(frozen=True)
class Gmfbo:
    """Real trajectory = twin + residual over gains; expected improvement through the metrics."""

    name: str = "gmfbo"
    summary: str = "twin corrected by a process on whole trajectories, judged through the metrics"
    reference: str = (
        "after Nobar et al. 2025, arXiv:2509.17952, and Astudillo and Frazier 2019, Bayesian "
        "optimization of composite functions"
    )
    correction: CorrectionOptions = CorrectionOptions(
        memory="latest", at_border="reflect", survey=SURVEY
    )

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Ask the real axis where the corrected twin promises most."""
        from gmfbo.acquisition.trajectory_improvement import expected_improvement
        from gmfbo.correction.mismatch import scaled_mismatch

        mismatch = scaled_mismatch(*corrected_and_twin(state, scaled=True))
        points, draws = _real_costs(state, rng)
        new = _is_new(points, state)
        if not new.any():
            blind = state.hold(rng.random(len(state.space)))
            return Proposal("IS1", blind, mismatch, "the twin has not succeeded anywhere new")
        incumbent = min(seen.objective for seen in state.of("IS1"))
        # Where no draw improves, the expected cost still orders the points.
        score = expected_improvement(draws, incumbent) - 1e-9 * draws.mean(axis=0)
        return Proposal("IS1", points[int(np.argmax(np.where(new, score, -np.inf)))], mismatch)

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least expected cost among the gains where the twin was run."""
        points, draws = _real_costs(state, np.random.default_rng(0))
        if not len(points):
            best = min(state.of("IS1"), key=lambda seen: seen.objective)
            return best.point, best.objective, 0.0
        column = int(np.argmin(draws.mean(axis=0)))
        return points[column], float(draws[:, column].mean()), float(draws[:, column].std())


def _real_costs(
    state: TuningState, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points where the twin was run, shape (q, d), and draws of the real cost, shape (n, q)."""
    from gmfbo.acquisition.trajectory_improvement import real_cost_draws
    from gmfbo.correction.residual_process import ResidualProcess

    experiment = state.experiment

    def cost_of(runs: NDArray[np.float64]) -> NDArray[np.float64]:
        return state.objective.value(experiment.metrics_of(times, runs))

    times = experiment.step_time + np.linspace(0.0, experiment.horizon, MOST_SAMPLES)
    points, simulated = _twin_runs(state, times)
    if state.fixed and len(points):
        # Held gains lie off the simulated points: the twin is interpolated there.
        held = state.hold(points)
        emulator = ResidualProcess.fit(points, simulated, lengthscale=LENGTHSCALES[0], centred=True)
        points, simulated = held, emulator.mean(held)
    real_points, residuals = _residuals(state, times)
    draws = []
    for lengthscale in LENGTHSCALES:
        residual = ResidualProcess.fit(real_points, residuals, lengthscale=lengthscale)
        deviations = residual.deviations(DRAWS, rng)
        draws.append(real_cost_draws(points, simulated, residual, cost_of, deviations))
    return points, np.concatenate(draws)


def _twin_runs(
    state: TuningState, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (q, d) and trajectories (q, m) of all that the twin was run for, IS3 included."""
    signal = state.experiment.signal
    points, runs = [np.empty((0, len(state.space)))], [np.empty((0, times.size))]
    for trial in state.trials:
        if trial.source == "IS1" or trial.status != "ok":
            continue
        values = trial.uncorrected.get(signal)
        runs.append(_sampled(trial, times, signal, values)[None, :])
        points.append(_point(state, trial)[None, :])
    return np.concatenate(points), np.concatenate(runs)


def _residuals(
    state: TuningState, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, d) and residuals (n, m) of the real runs that have a twin run beside them."""
    signal = state.experiment.signal
    beside = {
        trial.parent: trial
        for trial in state.trials
        if trial.source == "IS2" and trial.parent is not None and trial.status == "ok"
    }
    points, residuals = [np.empty((0, len(state.space)))], [np.empty((0, times.size))]
    for trial in state.trials:
        if trial.source == "IS1" and trial.status == "ok" and trial.number in beside:
            twin = _sampled(beside[trial.number], times, signal)
            residuals.append((_sampled(trial, times, signal) - twin)[None, :])
            points.append(_point(state, trial)[None, :])
    return np.concatenate(points), np.concatenate(residuals)


def _sampled(
    trial: Trial,
    times: NDArray[np.float64],
    signal: str,
    values: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """The signal of a run, or other values of it, at given times, shape (m,)."""
    recording = trial.recording
    values = recording.signal(signal) if values is None else values
    known = np.isfinite(values)
    return np.interp(times, recording.time[known], values[known])


def _point(state: TuningState, trial: Trial) -> NDArray[np.float64]:
    return state.space.to_unit([trial.gains[name] for name in state.space.names])


def _is_new(points: NDArray[np.float64], state: TuningState) -> NDArray[np.bool_]:
    """Points that are no repeat of a real run, and not next to one that failed, shape (q,)."""
    new = np.ones(len(points), dtype=bool)
    for seen in state.of("IS1"):
        distance = np.linalg.norm(points - seen.point, axis=1)
        new &= distance > (FAILED_RADIUS if seen.failed else REPEAT_RADIUS)
    return new
