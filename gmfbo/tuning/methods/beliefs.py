"""From the state of a study to what surrogate and acquisition take."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.trial import SourceName
from gmfbo.tuning.method import Proposal
from gmfbo.tuning.state import TuningState

if TYPE_CHECKING:
    from gmfbo.acquisition.maximise import Proposal as Found
    from gmfbo.acquisition.maximise import Search
    from gmfbo.surrogate.model import SourceModel
    from gmfbo.surrogate.observations import Observations
    from gmfbo.surrogate.truncated import TruncatedModel


def observations_of(state: TuningState, *sources: SourceName) -> Observations:
    """Points and costs of some sources.

    Parameters
    ----------
    state : TuningState
        With at least one run of these sources.
    *sources : str
        `IS1`, `IS2`, `IS3`.
    """
    from gmfbo.surrogate.observations import Observations

    return Observations.gather(
        [(seen.point, seen.source, seen.objective) for seen in state.of(*sources)]
    )


def unprompted_observations(state: TuningState, *sources: SourceName) -> Observations:
    """As `observations_of`, without the twin's runs beside real ones, which serve a correction.

    Parameters
    ----------
    state : TuningState
        With at least one run of these sources.
    *sources : str
        `IS1`, `IS2`, `IS3`.
    """
    from gmfbo.surrogate.observations import Observations

    return Observations.gather(
        [
            (seen.point, seen.source, seen.objective)
            for seen in state.of(*sources)
            if seen.source != "IS2" or seen.parent is None
        ]
    )


def corrected_and_twin(
    state: TuningState, *, scaled: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Costs of the corrected twin and of the twin at the same gains, each shape (n,).

    Parameters
    ----------
    state : TuningState
        What was observed.
    scaled : bool
        G instead of g.
    """
    pairs = [
        (seen.scaled, seen.uncorrected_scaled) if scaled else (seen.objective, seen.uncorrected)
        for seen in state.of("IS3")
    ]
    corrected, twin = np.array(pairs, dtype=float).reshape(-1, 2).T
    return corrected, twin


def search_of(state: TuningState) -> Search:
    """Where a proposal may lie: held gains and integers are respected."""
    from gmfbo.acquisition.maximise import Search

    space = state.space
    rounded = any(gain.integer for gain in space.gains)
    return Search(
        dimension=len(space),
        fixed=state.fixed_unit,
        snap=(lambda points: space.to_unit(space.from_unit(points))) if rounded else None,
    )


def source_of(found: Found) -> Literal["IS1", "IS2"]:
    """Whom a maximum of the acquisition asks."""
    return "IS1" if found.source == "IS1" else "IS2"


def single_source_model(state: TuningState) -> SourceModel:
    """Gaussian process on the real runs alone, one lengthscale a gain."""
    from gmfbo.surrogate.model import SourceModel, SurrogateSettings

    return SourceModel.fit(observations_of(state, "IS1"), SurrogateSettings(ard=True))


def improve_each_source(
    model: SourceModel | TruncatedModel,
    data: Observations,
    state: TuningState,
    twin_cost: float,
    mismatch: float | None = None,
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
    mismatch : float or None
        Mismatch that the cost follows from, for the log.
    """
    from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
    from gmfbo.acquisition.maximise import maximise

    acquisition = CostAwareExpectedImprovement(
        model,
        {name: float(data.values[data.of(name)].min()) for name in ("IS1", "IS2")},
        {"IS1": 1.0, "IS2": twin_cost},
    )
    found = maximise(acquisition, search_of(state), ["IS1", "IS2"], data)
    return Proposal(source_of(found), found.point, mismatch, model.note)


def least_expected(
    model: SourceModel | TruncatedModel, state: TuningState
) -> tuple[NDArray[np.float64], float, float]:
    """Point of the unit cube with the least posterior mean of the real axis.

    Parameters
    ----------
    model : SourceModel or TruncatedModel
        Fitted surrogate.
    state : TuningState
        What it was fitted to.

    Returns
    -------
    point : ndarray, shape (d,)
        In the unit cube.
    mean, std : float
        Posterior of the cost g there.
    """
    from gmfbo.acquisition.maximise import recommend

    point, mean = recommend(model, search_of(state))
    _, variance = model.predict(point[None, :], "IS1")
    return point, mean, float(np.sqrt(variance[0]))
