"""From the state of a study to what surrogate and acquisition take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.margins import MARGINS
from gmfbo.recordings.store.trial import SourceName
from gmfbo.space import SAME_POINT
from gmfbo.tuning.history.state import Observation, TuningState
from gmfbo.tuning.query.method import Proposal
from gmfbo.tuning.twin.runs_beside import runs_beside

if TYPE_CHECKING:
    from torch import Tensor

    from gmfbo.acquisition.feasibility import FeasibilityWeight, LogWeight
    from gmfbo.acquisition.finishing import FinishModel
    from gmfbo.acquisition.maximise import Proposal as Found
    from gmfbo.acquisition.maximise import Search
    from gmfbo.surrogate.model import SourceModel
    from gmfbo.surrogate.observations import Observations
    from gmfbo.surrogate.truncated import TruncatedModel


Predict = Callable[[NDArray[np.float64], SourceName], tuple[Any, Any]]
"""From points (q, d) and a source to posterior mean and variance of the cost, shape (q,)."""


def observations_of(state: TuningState, *sources: SourceName) -> Observations:
    """Points and costs of some sources.

    Parameters
    ----------
    state : TuningState
        With at least one run of these sources.
    *sources : str
        `IS1`, `IS2`, `IS3`.
    """
    return _gathered(state, [one for one in state.of(*sources) if one.counts])


def unprompted_observations(state: TuningState, *sources: SourceName) -> Observations:
    """As `observations_of`, without the twin's runs beside real ones, which serve a correction.

    Parameters
    ----------
    state : TuningState
        With at least one run of these sources.
    *sources : str
        `IS1`, `IS2`, `IS3`.
    """
    kept = [one for one in state.of(*sources) if one.source != "IS2" or one.parent is None]
    return _gathered(state, kept)


def _gathered(state: TuningState, seen: Sequence[Observation]) -> Observations:
    from gmfbo.surrogate.observations import Observations

    values = np.array([one.objective for one in seen])
    rows = [(one.point, one.source, one.objective) for one in seen]
    return Observations.gather(rows, state.extra_of(seen, values))


def corrected_and_twin(
    state: TuningState, *, scaled: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """g, or if `scaled` G, of the corrected twin and of the twin at equal gains, each (n,)."""
    pairs = [
        (seen.scaled, seen.uncorrected_scaled) if scaled else (seen.objective, seen.uncorrected)
        for seen in state.of("IS3")
        if not seen.outdated
    ]
    corrected, twin = np.array(pairs, dtype=float).reshape(-1, 2).T
    return corrected, twin


def axis_and_twin(state: TuningState) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """G of the axis, or of the twin corrected by it, and of the twin at equal gains, each (n,).

    Without corrected runs these are the real runs and the twin's runs beside them. Failed runs,
    and those from before a change of the plant, are left out.
    """
    if state.of("IS3"):
        return corrected_and_twin(state, scaled=True)
    beside = {number: trial.number for number, trial in runs_beside(state.trials).items()}
    seen = {one.number: one for one in state.observations}
    compared = [
        (real, seen[beside[real.number]]) for real in state.of("IS1") if real.number in beside
    ]
    pairs = [
        (real.scaled, twin.scaled)
        for real, twin in compared
        if not (real.outdated or real.failed or twin.failed)
    ]
    axis, twin = np.array(pairs, dtype=float).reshape(-1, 2).T
    return axis, twin


def search_of(state: TuningState) -> Search:
    """Where a proposal may lie: held gains, integers, limits and unsafe gains are respected.

    All methods that search by it weigh what they seek by the probability that the limits are
    met, and leave out gains that the axis must not be run at.
    """
    from gmfbo.acquisition.maximise import Search

    space, finishing = state.space, finishing_of(state)
    weights: list[LogWeight] = [finishing] if finishing else []
    if state.limits:
        weights.append(feasibility_of(state))
    moves = state.keep_out.moves
    rounded = any(gain.steps is not None for gain in space.gains)

    def snap(points: NDArray[np.float64]) -> NDArray[np.float64]:
        near = points if moves is None else state.hold(moves.nearest(points))
        return space.to_unit(space.from_unit(near)) if rounded else near

    return Search(
        dimension=len(space),
        fixed=state.fixed_unit,
        snap=snap if rounded or moves is not None else None,
        log_weight=partial(_together, weights) if weights else None,
        admits=(lambda points: admitted(state, points, finishing))
        if finishing or state.keep_out
        else None,
    )


def _together(weights: Sequence[LogWeight], points: Tensor) -> Tensor:
    total = weights[0](points)
    for weight in weights[1:]:
        total = total + weight(points)
    return total


def finishing_of(state: TuningState) -> FinishModel | None:
    """Where real runs finish, once one has not; None before, or where failed runs have a price."""
    from gmfbo.acquisition.finishing import FinishModel

    real = state.of("IS1")
    if not state.ranked or all(one.counts for one in real):
        return None
    return FinishModel.fit(
        np.stack([one.point for one in real]), np.array([one.counts for one in real])
    )


def admitted(
    state: TuningState, points: NDArray[np.float64], finishing: FinishModel | None
) -> NDArray[np.bool_]:
    """Points (q, d) at which the axis may be run and probably finishes, shape (q,)."""
    from gmfbo.acquisition.finishing import probable

    allowed = state.keep_out.admitted(points)
    if finishing is not None and allowed.any():
        allowed[allowed] = probable(finishing.log_probability(points[allowed]))
    return allowed


def seek_finished(state: TuningState) -> Proposal:
    """Query of the axis where a run most probably finishes, while none has."""
    search = search_of(state)
    pool = search.pool() if search.snap is None else np.unique(search.snap(search.pool()), axis=0)
    done = np.stack([one.point for one in state.of("IS1")])
    new = np.abs(pool[:, None, :] - done).max(axis=2).min(axis=1) > SAME_POINT
    pool = pool[new] if new.any() else pool
    best = int(np.argmax(search.log_weights(pool)))
    return Proposal("IS1", pool[best], note="no real run has finished: asks where one may")


def feasibility_of(state: TuningState) -> FeasibilityWeight:
    """Probability that gains meet the limits, by a Gaussian process on each limited metric.

    It knows real runs alone: what the twin says of a metric it says through the cost already,
    and a limit that the axis breaks must not be talked away by a twin.
    """
    from gmfbo.acquisition.feasibility import FeasibilityWeight
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings
    from gmfbo.surrogate.observations import Observations

    limited = []
    for name, most in state.limits.most.items():
        # Margins are the twin's whoever ran, so that its own runs tell of them too, and of a run
        # that failed they are known as well.
        of_twin = name in MARGINS
        runs = [
            one
            for one in (state.of("IS1", "IS2") if of_twin else state.of("IS1"))
            if np.isfinite(one.limited[name]) and (of_twin or one.counts)
        ]
        # The model of a single source: real runs and runs of the twin alike.
        seen = [(one.point, "IS1" if of_twin else one.source, one.limited[name]) for one in runs]
        # A metric that no run moved has no scale, and tells nothing of where it is met.
        if len({value for *_, value in seen}) > 1:
            extra = state.extra_of(runs, np.array([value for *_, value in seen]))
            data = Observations.gather(seen, extra)
            model = SourceModel.fit(data, SurrogateSettings(ard=True))
            limited.append((model, most))
    return FeasibilityWeight(limited)


def incumbent_of(state: TuningState, data: Observations, *sources: SourceName) -> float:
    """Incumbent of the sources: least cost g of the data, or of runs that meet the limits.

    After a change of the plant, of the runs since.
    """
    if state.ranked or state.limits or any(one.outdated for one in state.of(*sources)):
        return state.incumbent(*sources)
    return min(float(data.values[rows].min()) for name in sources if (rows := data.of(name)).any())


def has_tried(state: TuningState) -> bool:
    """Whether a run finished, and met the limits, that the next one has to improve on."""
    counted = [one for one in state.of("IS1") if one.counts]
    feasible = not state.limits or any(one.feasible for one in counted)
    return state.ranked and not state.unsettled and bool(counted) and feasible


def expected_incumbent(
    model: SourceModel | TruncatedModel, state: TuningState, data: Observations
) -> float:
    """Least expected cost g of the gains that were tried; the luckiest run promises too much.

    Where runs are not ranked, as in studies begun before, it is that of the best run.

    Parameters
    ----------
    model : SourceModel or TruncatedModel
        Fitted to `data`.
    state : TuningState
        What was observed.
    data : Observations
        Runs of the axis.
    """
    if not has_tried(state):
        return incumbent_of(state, data, "IS1")
    return least_expected_tried(model.predict, state)[1]


def expected_at(
    model: SourceModel | TruncatedModel, point: NDArray[np.float64]
) -> tuple[float, float]:
    """Predicted cost g of a real run at a point (d,), and its standard deviation."""
    mean, variance = model.predict(point[None, :], "IS1")
    return float(mean[0]), float(np.sqrt(variance[0]))


def source_of(found: Found) -> Literal["IS1", "IS2"]:
    """Whom a maximum of the acquisition asks."""
    return "IS1" if found.source == "IS1" else "IS2"


def single_source_model(state: TuningState) -> SourceModel:
    """Gaussian process on the real runs alone, one lengthscale a gain."""
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings

    return SourceModel.fit(observations_of(state, "IS1"), SurrogateSettings(ard=True))


def improve_axis(model: SourceModel, state: TuningState) -> Proposal:
    """Maximise expected improvement of the axis over the box, on the gains that were tried.

    Parameters
    ----------
    model : SourceModel
        Of the cost of the axis, whatever else it knows.
    state : TuningState
        With a finished real run.
    """
    from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
    from gmfbo.acquisition.maximise import maximise

    real = observations_of(state, "IS1")
    acquisition = CostAwareExpectedImprovement(
        model, {"IS1": expected_incumbent(model, state, real)}, {"IS1": 1.0}
    )
    found = maximise(acquisition, search_of(state), ["IS1"], real)
    expected = expected_at(model, found.point)
    return Proposal("IS1", found.point, note=model.note, expected=expected)


def improve_each_source(
    model: SourceModel | TruncatedModel,
    data: Observations,
    state: TuningState,
    twin_cost: float,
) -> Proposal:
    """Maximise EI / H over gains and source, each with the incumbent of its source.

    Parameters
    ----------
    model : SourceModel or TruncatedModel
        Fitted to `data`.
    data : Observations
        Runs of the axis and of the twin.
    state : TuningState
        Where a proposal may lie.
    twin_cost : float
        H of the twin [runs of the axis].
    """
    from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
    from gmfbo.acquisition.maximise import maximise

    acquisition = CostAwareExpectedImprovement(
        model,
        {name: incumbent_of(state, data, name) for name in ("IS1", "IS2")},
        {"IS1": 1.0, "IS2": twin_cost},
    )
    found = maximise(acquisition, search_of(state), ["IS1", "IS2"], data)
    expected = expected_at(model, found.point)
    return Proposal(source_of(found), found.point, note=model.note, expected=expected)


def least_expected(
    model: SourceModel | TruncatedModel, state: TuningState
) -> tuple[NDArray[np.float64], float, float]:
    """Point of the unit cube with the least posterior mean of the real axis.

    Where runs are ranked, it is one that was tried and finished.

    Returns
    -------
    point : ndarray, shape (d,)
        In the unit cube.
    mean, std : float
        Posterior of the cost g there.
    """
    if state.ranked:
        return least_expected_tried(model.predict, state)
    from gmfbo.acquisition.maximise import recommend

    point, mean = recommend(model, search_of(state))
    _, variance = model.predict(point[None, :], "IS1")
    return point, mean, float(np.sqrt(variance[0]))


def least_expected_tried(
    predict: Predict, state: TuningState
) -> tuple[NDArray[np.float64], float, float]:
    """Gains of the finished real run with the least posterior mean, that mean and its std.

    Runs that meet all limits come first, and those since a change of the plant.

    Parameters
    ----------
    predict : callable
        From points (q, d) and a source to posterior mean and variance of the cost, shape (q,).
    state : TuningState
        With a finished real run.
    """
    real = [one for one in state.of("IS1") if one.counts]
    real = [one for one in real if not one.outdated] or real
    real = [one for one in real if one.feasible] or real
    points = np.stack([one.point for one in real])
    mean, variance = predict(points, "IS1")
    best = int(np.argmin(mean))
    return points[best], float(mean[best]), float(np.sqrt(variance[best]))
