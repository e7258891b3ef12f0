"""The search against a dense oracle, and what it must never propose."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from gmfbo.acquisition.improvement import CostAwareExpectedImprovement
from gmfbo.acquisition.maximise import Search, maximise, recommend
from gmfbo.errors import InputError
from gmfbo.space import SAME_POINT
from gmfbo.surrogate.model import SourceModel, SurrogateSettings
from gmfbo.surrogate.observations import Observations

SOURCES = ("IS1", "IS2")


def observed(dimension: int, seed: int) -> Observations:
    rng = np.random.default_rng(seed)
    points = rng.random((10 * dimension, dimension))
    sources = tuple("IS1" if index % 3 == 0 else "IS2" for index in range(len(points)))
    return Observations(points, sources, np.sin(5.0 * points).sum(axis=1))


def improvement(observations: Observations) -> CostAwareExpectedImprovement:
    model = SourceModel.fit(observations, SurrogateSettings(source_lengthscale=None))
    incumbents = {name: float(observations.incumbent(name) or 0.0) for name in SOURCES}
    return CostAwareExpectedImprovement(model, incumbents, {"IS1": 1.0, "IS2": 0.3})


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_one_gain_is_as_good_as_a_dense_oracle(seed: int) -> None:
    observations = observed(1, seed)
    acquisition = improvement(observations)
    found = maximise(acquisition, Search(1), SOURCES, observations)
    dense = np.linspace(0.0, 1.0, 20001)
    best = -np.inf
    for column in (1.0, 0.0):
        inputs = torch.tensor(np.stack([dense, np.full_like(dense, column)], axis=-1))
        with torch.no_grad():
            best = max(best, float(acquisition(inputs[:, None, :]).max()))
    assert found.value >= best - 1e-4


def test_same_arguments_give_the_same_proposal_in_many_gains() -> None:
    observations = observed(4, 0)
    acquisition = improvement(observations)
    first, second = (
        maximise(acquisition, Search(4, seed=7), SOURCES, observations) for _ in range(2)
    )
    np.testing.assert_array_equal(first.point, second.point)
    assert (first.source, first.value) == (second.source, second.value)


def test_polish_in_many_gains_is_no_worse_than_any_point_of_the_pool() -> None:
    observations = observed(4, 1)
    acquisition, search = improvement(observations), Search(4, seed=3)
    pool = search.pool()
    with torch.no_grad():
        inputs = torch.tensor(np.hstack([pool, np.ones((len(pool), 1))]))
        best = float(acquisition(inputs[:, None, :]).max())
    assert maximise(acquisition, search, ["IS1"], observations).value >= best


def test_what_a_source_ran_is_not_asked_of_it_again() -> None:
    observations = observed(2, 3)
    acquisition = improvement(observations)
    taken = observations
    for _ in range(3):
        found = maximise(acquisition, Search(2), ["IS1"], taken)
        ran = taken.points[taken.of("IS1")]
        assert np.abs(ran - found.point).max(axis=1).min() > SAME_POINT
        taken = Observations(
            np.vstack([taken.points, found.point]),
            (*taken.sources, "IS1"),
            np.append(taken.values, 0.0),
        )


def test_fixed_gains_stay_and_snapped_gains_lie_on_their_raster() -> None:
    def on_raster(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.round(points * 8.0) / 8.0

    observations = observed(2, 4)
    acquisition = improvement(observations)
    held = maximise(acquisition, Search(2, fixed={1: 0.25}), SOURCES, observations)
    assert held.point[1] == 0.25
    snapped = maximise(acquisition, Search(2, snap=on_raster), SOURCES, observations)
    np.testing.assert_allclose(snapped.point * 8.0, np.round(snapped.point * 8.0), atol=1e-12)


def test_exhausted_raster_is_an_error_and_not_a_repeat() -> None:
    def two_points(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.round(points)

    observations = Observations(np.array([[0.0], [1.0]]), ("IS1", "IS1"), np.array([1.0, 2.0]))
    model = SourceModel.fit(observations)
    acquisition = CostAwareExpectedImprovement(model, {"IS1": 1.0}, {"IS1": 1.0})
    with pytest.raises(InputError, match="all candidate gains were run already by IS1"):
        maximise(acquisition, Search(1, snap=two_points), ["IS1"], observations)


def test_recommendation_is_the_least_posterior_mean_of_the_axis() -> None:
    observations = observed(2, 5)
    model = SourceModel.fit(observations)
    point, mean = recommend(model, Search(2))
    dense = np.random.default_rng(6).random((20000, 2))
    assert mean <= model.predict(dense, "IS1")[0].min() + 1e-6
    assert model.predict([point], "IS1")[0][0] == pytest.approx(mean)


def test_impossible_searches_are_refused() -> None:
    with pytest.raises(InputError, match="all 1 gains are fixed"):
        Search(1, fixed={0: 0.5})
    with pytest.raises(InputError, match=r"fixed columns 0\.\.1"):
        Search(2, fixed={5: 0.5})
