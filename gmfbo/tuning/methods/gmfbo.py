"""The twin corrected at the level of trajectories, as the prior mean of the surrogate.

The real trajectory is the twin's plus a residual that changes smoothly with the gains. Wherever
the twin was run, that gives an expected cost of the real axis; a Gaussian process on what the
real runs say beyond it carries the rest, on a scale that is measured by leaving real runs out.
The real axis is asked where the expected improvement is largest. The twin is cheap, so it is run
over the whole box once, and around each real run. These runs are candidates, and are not corrected
one by one (IS3): the residual process corrects all of them at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.limits import Limits
from gmfbo.objective.margins import MARGINS
from gmfbo.recordings.store.trial import SourceName
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.history.worth import noise_of_one_run
from gmfbo.tuning.methods.beliefs import (
    Predict,
    axis_and_twin,
    feasibility_of,
    has_tried,
    least_expected,
    least_expected_tried,
    single_source_model,
)
from gmfbo.tuning.methods.twin_rows import (
    axis_runs,
    cost_of_rows,
    modelled_runs,
    sample_times,
    twin_runs,
)
from gmfbo.tuning.query.method import CorrectionOptions, Proposal

if TYPE_CHECKING:
    from gmfbo.surrogate.corrected_twin import CorrectedTwinModel

SURVEY = 400
"""Runs of the twin over the box; a region of one percent of two gains then holds about four."""

CLOSER = 8
"""Runs of the twin in each stage of a closer look for each gain; two stages before a query."""

REPEAT_RADIUS, FAILED_RADIUS = 0.002, 0.05
"""Distances in the unit cube that are kept from real runs, and from those that failed."""

CORRECTION = CorrectionOptions(
    memory="latest", at_border="reflect", corrected=False, survey=SURVEY, closer=CLOSER
)


@dataclass(frozen=True)
class Gmfbo:
    """Cost of the corrected twin as prior mean; expected improvement on the real axis."""

    name: str = "gmfbo"
    summary: str = "twin corrected trajectory by trajectory, its cost the surrogate's prior mean"
    reference: str = (
        "after Nobar et al. 2025, arXiv:2509.17952; discrepancy before the cost as in Astudillo "
        "and Frazier 2019, Bayesian optimization of composite functions"
    )
    correction: CorrectionOptions = CORRECTION

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Ask the real axis where the corrected twin promises most."""
        from gmfbo.objective.mismatch import scaled_mismatch

        mismatch = scaled_mismatch(*axis_and_twin(state))
        belief = _Belief.of(state)
        point = belief.most_promising(state)
        if point is None:
            blind = state.hold(rng.random(len(state.space)))
            return Proposal("IS1", blind, mismatch, "the twin has not succeeded anywhere new")
        return Proposal("IS1", point, mismatch, expected=belief.at(point))

    def promising(self, state: TuningState) -> NDArray[np.float64]:
        """Gains with the largest expected improvement, and with the least expected cost."""
        belief = _Belief.of(state)
        point = belief.most_promising(state)
        if point is None:
            return np.empty((0, len(state.space)))
        return np.stack([point, belief.points[belief.least_expected()]])

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least expected cost among the gains where the twin was run."""
        if state.ranked:
            return _recommended_tried(state)
        belief = _Belief.of(state)
        if not len(belief.points):
            best = min(state.of("IS1"), key=lambda seen: seen.objective)
            return best.point, best.objective, 0.0
        row = belief.least_expected()
        return belief.points[row], float(belief.mean[row]), float(np.sqrt(belief.variance[row]))


@dataclass(frozen=True, eq=False)
class _Belief:
    """What is believed of the axis at the q points where the twin was run.

    Attributes
    ----------
    points : ndarray, shape (q, d)
        In the unit cube.
    mean, variance : ndarray, shape (q,)
        Of the cost.
    log_weight : ndarray, shape (q,)
        Log probability that the limits are met.
    incumbent : float
        Expected cost at the best gains that were tried: the luckiest run promises too much.
    noise : float
        Standard deviation of the cost of a repeated run.
    """

    points: NDArray[np.float64]
    mean: NDArray[np.float64]
    variance: NDArray[np.float64]
    log_weight: NDArray[np.float64]
    incumbent: float
    noise: float = 0.0

    @classmethod
    def of(cls, state: TuningState) -> _Belief:
        """Fit the corrected twin to all that was observed."""
        times = sample_times(state)
        points, simulated = twin_at_points(state, times)
        if not len(points):
            return cls(points, np.empty(0), np.empty(0), np.empty(0), state.incumbent())
        best, noise = state.incumbent(), 0.0
        if not modelled_runs(state):
            # No run ended well: the twin as it is, about as wrong as its costs differ.
            mean = cost_of_rows(state, times)(simulated)
            variance = np.full(len(points), float(np.var(mean)) or 1.0)
            corrected, weight = simulated, np.zeros(len(points))
        else:
            model = corrected_model(state, times, noise_of_one_run(state) if state.ranked else 0.0)
            mean, variance = model.predict(points, simulated)
            noise = model.noise
            if has_tried(state):
                best = least_expected_tried(_beside(model), state)[1]
            corrected = model.trajectory(points, simulated)
            weight = log_limit_weight(state, times, points, simulated)
        if state.ranked:
            weight = weight + log_finishing(state, times, points, corrected[:, : times.size])
        return cls(points, mean, variance, weight, best, noise)

    def most_promising(self, state: TuningState) -> NDArray[np.float64] | None:
        """Point (d,) of the largest expected improvement among the new ones; None without any."""
        from gmfbo.acquisition.improvement import log_improvement

        # A repeat of a real run has no variance left, and is no candidate.
        new = is_new(self.points, state)
        if not new.any() and state.keep_out.moves is not None:
            return self._towards(state)
        if state.ranked and any(not one.counts for one in state.of("IS1")):
            from gmfbo.acquisition.finishing import probable

            new[new] = probable(self.log_weight[new])
        if not new.any():
            return None
        gain = log_improvement(self.mean[new], self.variance[new], self.incumbent)
        found: NDArray[np.float64] = self.points[new][int(np.argmax(gain + self.log_weight[new]))]
        return found

    def _towards(self, state: TuningState) -> NDArray[np.float64]:
        """Promising point, moved to where a run may be made: the twin did not run there yet."""
        far = replace(state, keep_out=replace(state.keep_out, moves=None))
        found = self.most_promising(far)
        assert state.keep_out.moves is not None
        start = self.points[self.least_expected()] if found is None else found
        return np.asarray(state.hold(state.keep_out.moves.nearest(start[None, :])[0]))

    def at(self, point: NDArray[np.float64]) -> tuple[float, float] | None:
        """Expected cost of a run and its standard deviation at a point (d,), where the twin ran."""
        row = int(np.argmin(np.abs(self.points - point).max(axis=1)))
        if np.abs(self.points[row] - point).max() > 0.0:
            return None
        return float(self.mean[row]), float(np.sqrt(self.variance[row] + self.noise**2))

    def least_expected(self) -> int:
        """Row of the least expected cost where the limits are probably met."""
        probable = self.log_weight >= min(np.log(0.5), float(self.log_weight.max()))
        return int(np.argmin(np.where(probable, self.mean, np.inf)))


def twin_at_points(
    state: TuningState, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (q, d) that a proposal may be, and the twin there, see `twin_runs`.

    Parameters
    ----------
    state : TuningState
        What was observed.
    times : ndarray, shape (m,)
        [s] See `sample_times`.
    """
    from gmfbo.correction.residual_process import NUGGET, ResidualProcess
    from gmfbo.surrogate.smoothness import likeliest_smoothness

    points, simulated = twin_runs(state, times)
    if not len(points) or not state.fixed:
        return points, simulated
    # Held gains lie off the simulated points: the twin is interpolated there.
    samples = simulated[:, : times.size]
    # The twin repeats itself.
    known = likeliest_smoothness(points, samples - samples.mean(axis=0), repeated=(NUGGET,))
    emulator = ResidualProcess.fit(points, simulated, lengthscale=known.lengthscale, centred=True)
    held = state.hold(points)
    return held, emulator.mean(held)


def log_limit_weight(
    state: TuningState,
    times: NDArray[np.float64],
    points: NDArray[np.float64],
    simulated: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Log probability, shape (q,), that the corrected twin meets each limit."""
    from gmfbo.objective.limits import log_feasibility
    from gmfbo.surrogate.corrected_twin import CorrectedTwinModel

    total = np.zeros(len(points))
    of_twin = {n: v for n, v in state.limits.stated.items() if n in MARGINS}
    if of_twin:
        for known, most in feasibility_of(replace(state, limits=Limits(of_twin))).limited:
            total += log_feasibility(*known.predict(points, "IS1"), most)
    for name, most in state.limits.most.items():
        if name in of_twin:
            continue
        runs, _ = axis_runs(state, times)
        values = np.array([seen.limited[name] for _, seen in modelled_runs(state)])

        def limited_of(
            trajectories: NDArray[np.float64], name: str = name, middle: float = values.mean()
        ) -> NDArray[np.float64]:
            metrics = state.experiment.metrics_of(times, trajectories[:, : times.size], {name})
            found = state.limits.limited(metrics)[name]
            # What needs other signals than the scored one is known from real runs alone.
            known = np.where(np.isnan(found), middle, found)
            return np.broadcast_to(known, len(trajectories))

        model = CorrectedTwinModel.fit(replace(runs, values=values), limited_of)
        total += log_feasibility(*model.predict(points, simulated), most)
    return total


def corrected_model(
    state: TuningState, times: NDArray[np.float64], noise: float = 0.0
) -> CorrectedTwinModel:
    """Fit the corrected twin to all real runs, whose cost has a noise [g] of its own."""
    from gmfbo.surrogate.corrected_twin import CorrectedTwinModel

    runs, cost_of = axis_runs(state, times)
    return CorrectedTwinModel.fit(runs, cost_of, noise)


def log_finishing(
    state: TuningState,
    times: NDArray[np.float64],
    points: NDArray[np.float64],
    corrected: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Log probability, shape (q,), that a run finishes; the corrected twin's word is the prior.

    Parameters
    ----------
    state : TuningState
        What was observed.
    times : ndarray, shape (m,)
        [s] See `sample_times`.
    points : ndarray, shape (q, d)
        In the unit cube.
    corrected : ndarray, shape (q, m)
        Expected trajectories of the axis there.
    """
    from gmfbo.acquisition.finishing import TWIN_BELIEVED, FinishModel, prior_of

    settles = state.late_error_of(times, corrected) <= 1.0
    prior = prior_of(np.where(settles | state.unsettled, TWIN_BELIEVED, 1.0 - TWIN_BELIEVED))
    real = state.of("IS1")
    if not real:
        return np.zeros(len(points))
    at = np.stack([one.point for one in real])
    # The twin's word at the real runs is that at the nearest point where it was run.
    nearest = np.argmin(((at[:, None, :] - points) ** 2).sum(axis=2), axis=1)
    finished = np.array([one.counts for one in real])
    model = FinishModel.fit(at, finished, prior[nearest])
    return model.log_probability(points, prior)


def _recommended_tried(state: TuningState) -> tuple[NDArray[np.float64], float, float]:
    """Least expected cost among the gains that were tried and finished."""
    times = sample_times(state)
    if not any(trial.source != "IS1" and trial.status == "ok" for trial in state.trials):
        return least_expected(single_source_model(state), state)
    # Without its noise the model believes each run, and the luckiest one would be recommended.
    model = corrected_model(state, times, noise_of_one_run(state))
    return least_expected_tried(_beside(model), state)


def _beside(model: CorrectedTwinModel) -> Predict:
    """Predictions at gains that were run, from the twin's run beside each."""
    known = model.runs

    def predict(
        at: NDArray[np.float64], source: SourceName
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        # The twin beside the run itself; none right after a run, and where the twin failed.
        same = np.argmin(((at[:, None, :] - known.points) ** 2).sum(axis=2), axis=1)
        return model.predict(at, known.simulated[same])

    return predict


def is_new(points: NDArray[np.float64], state: TuningState) -> NDArray[np.bool_]:
    """Points that are no repeat of a real run, and not next to one that failed, shape (q,)."""
    new = np.ones(len(points), dtype=bool)
    for seen in state.of("IS1"):
        if seen.outdated and not seen.failed:
            # The plant has changed since: a repeat tells something.
            continue
        distance = np.linalg.norm(points - seen.point, axis=1)
        new &= distance > (FAILED_RADIUS if seen.failed else REPEAT_RADIUS)
    new[new] = state.keep_out.admitted(points[new])
    return new
