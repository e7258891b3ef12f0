"""What a practitioner with a model of low order does: identify it, and optimise the gains on it.

The plant (inertia or lag, friction, gain, delay) is identified from all real runs, and the gains
with the least cost on that loop are run next. Once they were run, a Gaussian process on what the
real runs say beyond the model carries on, as a practitioner goes on by hand.

The controller is read out of runs of the twin. Where it cannot be read, as with a cascade that has
states of its own, it is simulated by the twin's FMU: the model is then the twin, with its uncertain
parameters, friction, a constant load, a delay and a lag identified from the real runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.objective.tracking import COMMAND_METRICS
from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import least_expected, seek_finished, single_source_model
from gmfbo.tuning.methods.bo_ei import SingleSourceImprovement
from gmfbo.tuning.methods.gmfbo import CORRECTION
from gmfbo.tuning.methods.low_order.closed_loop import simulate
from gmfbo.tuning.methods.low_order.control_law import ControlLaw
from gmfbo.tuning.methods.low_order.identification import Identified, identify
from gmfbo.tuning.methods.low_order.runs import SampledRuns
from gmfbo.tuning.methods.optimum_of_twin import RUN_RADIUS, at_optimum_or_beyond, optimum_of_twin
from gmfbo.tuning.query.method import CorrectionOptions, Proposal

SURVEY = 50
"""Runs of the twin that the controller is read from, beside the initial ones: products of up to
three of two gains are ten numbers, of three gains twenty."""

READING = CorrectionOptions(survey=SURVEY, around_real=False)

MOST_READ = 60
"""Runs of the twin that the controller is read from, at most: the initial ones and `SURVEY`."""

COVER, NEARER, ROUNDS = 512, 128, 3
"""Gains at which the model is simulated: over the box, then around the best, so many times."""

MOST_SAMPLES = 400
"""Instants at which a simulated response is scored."""


@dataclass(frozen=True)
class IdentifyThenOptimise:
    """Optimum of an identified loop of low order, then improvement over it."""

    name: str = "identify_then_optimise"
    summary: str = "a plant of low order identified from the real runs, the gains optimised on it"
    reference: str = (
        "Gevers 2005, Identification for control; discrepancy after Kennedy and O'Hagan 2001"
    )
    correction: CorrectionOptions = CORRECTION

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Ask the axis at the optimum of the model, or where it may still be improved on."""
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        loop = _Loop.identified(state)
        if isinstance(loop, str):
            found = at_optimum_or_beyond(state)
            if found is not None:
                return found
            other = SingleSourceImprovement().propose(state, rng)
            return Proposal("IS1", other.point, note=f"{loop}: as bo_ei", expected=other.expected)
        points, cost = loop.surveyed(state, rng)
        run = np.stack([one.point for one in state.of("IS1")])
        distance = np.abs(points[:, None, :] - run).max(axis=2).min(axis=1)
        best = int(np.argmin(cost))
        if not np.isfinite(cost[best]):
            other = SingleSourceImprovement().propose(state, rng)
            return Proposal("IS1", other.point, note="the model settles nowhere: as bo_ei")
        if distance[best] > RUN_RADIUS:
            return Proposal("IS1", points[best], note=loop.note)
        open_ = np.isfinite(cost) & (distance > RUN_RADIUS)
        if not open_.any():
            return Proposal("IS1", points[best], note=loop.note)
        return _beyond(state, loop, points[open_], cost[open_])

    def promising(self, state: TuningState) -> NDArray[np.float64]:
        """Optimum of the twin, shape (1, d), for a closer look; (0, d) where it is not needed."""
        law = _law(state)
        best = None if law is not None and law.is_read else optimum_of_twin(state)
        return np.empty((0, len(state.space))) if best is None else best[None, :]

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Least posterior mean of a Gaussian process on the real runs."""
        return least_expected(single_source_model(state), state)


def _beyond(
    state: TuningState, loop: _Loop, points: NDArray[np.float64], cost: NDArray[np.float64]
) -> Proposal:
    """Expected improvement where the model is right but for a smooth function of the gains."""
    from gmfbo.acquisition.improvement import log_improvement
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings
    from gmfbo.surrogate.observations import Observations

    real = [one for one in state.of("IS1") if one.counts]
    at = np.stack([one.point for one in real])
    model_cost = loop.cost(state, at)
    known = np.isfinite(model_cost)
    model_cost = np.where(known, model_cost, np.max(cost))
    beyond = np.array([one.objective for one in real]) - model_cost
    rows = [(p, "IS1", float(value)) for p, value in zip(at, beyond, strict=True)]
    process = SourceModel.fit(Observations.gather(rows), SurrogateSettings(ard=True))
    mean, variance = process.predict(points, "IS1")
    row = int(np.argmax(log_improvement(cost + mean, variance, state.incumbent())))
    expected = float(cost[row] + mean[row]), float(np.sqrt(variance[row]))
    return Proposal("IS1", points[row], note=loop.note, expected=expected)


@dataclass(frozen=True, eq=False)
class _Loop:
    """The controller that was read, and the plant that was identified.

    Attributes
    ----------
    law : ControlLaw
        Of the twin and the axis.
    found : Identified
        The plant.
    real : SampledRuns
        Runs that it was identified from.
    """

    law: ControlLaw
    found: Identified
    real: SampledRuns

    @classmethod
    def identified(cls, state: TuningState) -> _Loop | str:
        """The loop, or the reason why there is none."""
        law = _law(state)
        settled = {one.number for one in state.of("IS1") if not one.failed and not one.outdated}
        real = SampledRuns.of([t for t in state.trials if t.number in settled], state)
        if law is None or real is None:
            return "no command was recorded"
        if not law.is_read:
            return "the controller could not be read out of the twin's runs"
        return cls(law, identify(law, real), real)

    @property
    def note(self) -> str:
        """The model in a line."""
        plant = self.found.plant
        parts = [f"gain {plant.gain[0]:.3g}", f"damping {plant.damping[0]:.3g}/s"]
        if plant.stiffness[0]:
            parts.append(f"stiffness {plant.stiffness[0]:.3g}/s2")
        if plant.coulomb[0]:
            parts.append(f"friction {plant.coulomb[0]:.3g}")
        return f"model: {', '.join(parts)}, delay {1e3 * plant.delay[0]:.3g} ms"

    def surveyed(
        self, state: TuningState, rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (q, d) where the axis may be run, and their cost on the model, shape (q,)."""
        width = len(state.space)
        points = _allowed(state, qmc.Sobol(d=width, rng=rng).random(COVER))
        cost = self.cost(state, points)
        spread = 0.1
        for _ in range(ROUNDS):
            if not np.isfinite(cost).any():
                break
            around = points[int(np.argmin(cost))] + spread * rng.standard_normal((NEARER, width))
            new = _allowed(state, np.clip(around, 0.0, 1.0))
            points, cost = np.vstack([points, new]), np.append(cost, self.cost(state, new))
            spread *= 0.3
        return points, cost

    def cost(self, state: TuningState, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cost g on the model, shape (q,); infinite where it does not settle or meet a limit.

        Parameters
        ----------
        state : TuningState
            With the objective.
        points : ndarray, shape (q, d)
            In the unit cube.
        """
        many = len(points)
        gains = state.space.from_unit(points)
        most = np.maximum(np.abs(state.space.bounds).max(axis=0), np.finfo(float).tiny)
        start = np.array([[self.real.measured[:, 0].mean()], [self.real.command[:, 0].mean()]])
        y, u = simulate(
            self.law,
            self.found.plant.repeated(many),
            gains / most,
            np.tile(self.real.reference[:1], (many, 1)),
            np.repeat(start, many, axis=1),
            self.real.step,
        )
        times = state.experiment.scored_times(MOST_SAMPLES)
        at_times = np.stack([np.interp(times, self.real.time, one) for one in y])
        metrics = dict(state.experiment.metrics_of(times, at_times))
        metrics |= self._of_command(state, y, u)
        cost = np.array(state.objective.value(metrics))
        cost[state.late_error_of(times, at_times) > 1.0] = np.inf
        for name, values in state.limits.limited(metrics).items():
            cost[values > state.limits.most[name]] = np.inf
        return cost

    def _of_command(
        self, state: TuningState, y: NDArray[np.float64], u: NDArray[np.float64]
    ) -> dict[str, NDArray[np.float64]]:
        """Metrics of the command where they count, run by run."""
        counted = {*state.objective.weights, *state.limits.most} & set(COMMAND_METRICS)
        if not counted:
            return {}
        signal, command = state.experiment.signal, state.experiment.terms.command
        found = []
        for measured, one in zip(y, u, strict=True):
            run = Recording(time=self.real.time, signals={signal: measured, str(command): one})
            found.append(state.experiment.metrics(run))
        return {name: np.array([each[name] for each in found]) for name in counted}


_LAWS: WeakKeyDictionary[Trial, ControlLaw] = WeakKeyDictionary()
"""Law by the first run of a twin: all of its runs have the same, and it takes a second to read."""


def _law(state: TuningState) -> ControlLaw | None:
    """Controller of the twin; None where its command was not recorded."""
    runs = [trial for trial in state.trials if trial.source == "IS2"][:MOST_READ]
    if not runs:
        return None
    if runs[0] not in _LAWS:
        twin = SampledRuns.of(runs, state)
        if twin is None or len(twin) < 2:
            return None
        _LAWS[runs[0]] = ControlLaw.read(twin)
    return _LAWS[runs[0]]


def _allowed(state: TuningState, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points, moved to where the axis may be run; held gains and steps of gains respected."""
    held, moves = state.hold(points), state.keep_out.moves
    if moves is not None:
        held = state.hold(moves.nearest(held))
    snapped = state.space.to_unit(state.space.from_unit(held))
    kept = snapped[state.keep_out.admitted(snapped)]
    return kept if len(kept) else snapped
