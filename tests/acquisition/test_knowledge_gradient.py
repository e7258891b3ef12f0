"""Whom the knowledge gradient asks, and that it does so repeatably and within what is allowed."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from botorch.models.transforms.outcome import Standardize
from botorch.posteriors.gpytorch import GPyTorchPosterior
from botorch.sampling.normal import SobolQMCNormalSampler
from numpy.typing import NDArray
from scipy.stats import norm

from gmfbo.acquisition.knowledge_gradient import (
    KnowledgeGradientSettings,
    best_query,
    knowledge_gradient,
)
from gmfbo.acquisition.maximise import Proposal, Search, recommend
from gmfbo.acquisition.relevance import information_per_cost
from gmfbo.correction.torch_setup import exact_algebra
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import Observations, with_source
from gmfbo.surrogate.truncated import TruncatedModel

QUICK = KnowledgeGradientSettings(fantasies=8, restarts=2, raw_samples=16, iterations=20)
BOTH = ("IS1", "IS2")


def axis(points: NDArray[np.float64]) -> NDArray[np.float64]:
    cost: NDArray[np.float64] = 4.0 * np.sum((points - np.array([0.7, 0.3])) ** 2, axis=1)
    return cost


def unrelated(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return 2.0 * np.cos(5.0 * points[:, 0]) * np.cos(4.0 * points[:, 1])


def observed(twin_runs: int, *, useless: bool = False) -> Observations:
    """Three runs of the axis; a twin that agrees, or that has nothing to do with it."""
    points = np.random.default_rng(3).random((3 + twin_runs, 2))
    twin = unrelated(points) if useless else axis(points)
    values = np.where(np.arange(3 + twin_runs) < 3, axis(points), twin)
    return Observations(points, ("IS1",) * 3 + ("IS2",) * twin_runs, values)


def asked(data: Observations, search: Search | None = None, seed: int = 5) -> Proposal:
    model = TruncatedModel.fit(data)
    return best_query(model, search or Search(2), BOTH, data, QUICK, seed)


def test_the_cheap_source_is_asked_while_the_sources_agree() -> None:
    assert asked(observed(8)).source == "IS2"


def test_the_axis_is_asked_where_the_twin_was_run_all_over_and_is_useless() -> None:
    assert asked(observed(45, useless=True)).source == "IS1"


def test_same_seed_gives_the_same_query_and_another_may_not() -> None:
    data = observed(8)
    first, second = asked(data), asked(data)
    np.testing.assert_array_equal(first.point, second.point)
    assert first.value == second.value
    assert not np.array_equal(first.point, asked(data, seed=6).point)


def test_held_and_rounded_gains_are_respected() -> None:
    search = Search(2, fixed={1: 0.25}, snap=lambda points: np.round(points * 20.0) / 20.0)
    point = asked(observed(8), search).point
    assert point[1] == 0.25
    assert point[0] * 20.0 == pytest.approx(round(point[0] * 20.0))


def learned_at(
    model: TruncatedModel, here: torch.Tensor, inputs: torch.Tensor, draws: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean over `inputs`, a row for each outcome of a run: it moves by a normal draw times
    c(k, .) / sqrt(c(k, k) + noise)."""
    with exact_algebra(), torch.no_grad():
        joint = model.posterior(torch.cat([here, inputs]))
    assert isinstance(joint, GPyTorchPosterior)
    covariance = joint.distribution.covariance_matrix.numpy()
    transform = model.outcome_transform
    assert isinstance(transform, Standardize)
    noise = float(model.likelihood.noise.detach()) * float(transform.stdvs.item()) ** 2
    slope = covariance[0, 1:] / np.sqrt(covariance[0, 0] + noise)
    moved: NDArray[np.float64] = joint.mean.numpy()[1:, 0] + slope * draws[:, None]
    return moved


@pytest.mark.parametrize("source", BOTH)
def test_value_is_the_closed_form_of_the_linear_gaussian_case(source: str) -> None:
    data, search = observed(8), Search(2)
    model = TruncatedModel.fit(data)
    acquisition, sampler = (
        knowledge_gradient(model, search, 64, seed=1),
        SobolQMCNormalSampler(torch.Size([64]), seed=1),
    )
    here = with_source(np.array([0.4, 0.6]), source)
    inputs = with_source(search.pool(), "IS1")
    _, least = recommend(model, search)
    with exact_algebra(), torch.no_grad():
        sampler(model.posterior(here, observation_noise=True))
    normal = sampler.base_samples
    assert isinstance(normal, torch.Tensor)
    learned = learned_at(model, here, inputs, normal.numpy().ravel())
    gained = least - learned.min(axis=1).mean()
    with exact_algebra(), torch.no_grad():
        value = float(acquisition(torch.cat([here, inputs[learned.argmin(axis=1)]])[None]))
    assert value == pytest.approx(gained, rel=1e-4)


def test_what_is_weighed_against_the_axis_is_the_expected_gain_over_the_cost() -> None:
    """Not the gains alone over the cost: a cheap run would seem worth twice what it is."""
    data, search = observed(8), Search(2)
    model = TruncatedModel.fit(data)
    found = asked(data)
    assert found.source == "IS2"
    draws = norm.ppf((np.arange(256) + 0.5) / 256)
    inputs = with_source(search.pool(), "IS1")
    learned = learned_at(model, with_source(found.point, found.source), inputs, draws)
    _, least = recommend(model, search)
    assert found.value == pytest.approx((least - learned.min(axis=1).mean()) / 0.1, rel=0.25)


def test_nothing_is_left_to_ask_when_every_gain_was_run() -> None:
    corners = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    data = Observations(
        np.tile(corners, (2, 1)), ("IS1",) * 4 + ("IS2",) * 4, axis(np.tile(corners, (2, 1)))
    )
    with pytest.raises(InputError, match="all candidate gains were run already by IS1, IS2"):
        asked(data, Search(2, snap=np.round))


def test_information_is_more_where_less_is_known() -> None:
    """Of two gains that may be the best: one the axis ran, the other it never came near."""
    data = observed(8)
    model = TruncatedModel.fit(data)
    known, unknown = data.points[1], np.array([0.7, 0.3])
    told = [
        information_per_cost(model, Search(2), point, "IS1", seed=1) for point in (known, unknown)
    ]
    assert 0.0 <= told[0] < told[1]


def test_information_of_the_twin_is_less_but_for_its_cost() -> None:
    model = TruncatedModel.fit(observed(8))
    point, _ = recommend(model, Search(2))
    axis_told, twin_told = (
        information_per_cost(model, Search(2), point, source, seed=1) for source in BOTH
    )
    assert 0.1 * twin_told < axis_told
