"""Whom the knowledge gradient asks, what that is worth, and what it leaves alone."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from botorch.acquisition.knowledge_gradient import qMultiFidelityKnowledgeGradient
from botorch.acquisition.objective import ScalarizedPosteriorTransform
from botorch.sampling.normal import SobolQMCNormalSampler
from numpy.typing import NDArray

from gmfbo.acquisition.knowledge_gradient import KnowledgeGradient
from gmfbo.acquisition.maximise import Proposal, Search, maximise, recommend
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import Observations, with_source
from gmfbo.surrogate.truncated import TruncatedModel

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


def asked(data: Observations, search: Search | None = None) -> Proposal:
    search = search or Search(2)
    return maximise(KnowledgeGradient(TruncatedModel.fit(data), search), search, BOTH, data)


def test_the_cheap_source_is_asked_while_the_sources_agree() -> None:
    assert asked(observed(8)).source == "IS2"


@pytest.fixture(scope="module")
def beside_a_useless_twin() -> Proposal:
    return asked(observed(45, useless=True))


def test_the_axis_is_asked_where_the_twin_was_run_all_over_and_is_useless(
    beside_a_useless_twin: Proposal,
) -> None:
    assert beside_a_useless_twin.source == "IS1"


def test_limits_and_what_is_kept_out_are_respected(beside_a_useless_twin: Proposal) -> None:
    def left(points: NDArray[np.float64]) -> NDArray[np.bool_]:
        return points[:, 0] < 0.5

    def log_weight(points: torch.Tensor) -> torch.Tensor:
        return torch.where(points[..., 1] > 0.6, 0.0, -30.0).to(DTYPE)

    data = observed(45, useless=True)
    free = beside_a_useless_twin
    assert free.source == "IS1"
    assert not left(free.point[None, :])[0] or free.point[1] < 0.6
    kept = asked(data, Search(2, admits=left, log_weight=log_weight))
    assert kept.point[1] > 0.6
    assert kept.source == "IS1"
    assert left(kept.point[None, :])[0]


def test_held_and_rounded_gains_are_respected() -> None:
    search = Search(2, fixed={1: 0.25}, snap=lambda points: np.round(points * 20.0) / 20.0)
    point = asked(observed(8), search).point
    assert point[1] == 0.25
    assert point[0] * 20.0 == pytest.approx(round(point[0] * 20.0))


@pytest.mark.parametrize(("source", "cost"), [("IS1", 1.0), ("IS2", 0.1)])
@pytest.mark.parametrize("gains", [(0.68, 0.35), (0.1, 0.9)])
def test_value_is_that_of_botorchs_fantasies_over_the_cost(
    source: str, cost: float, gains: tuple[float, float]
) -> None:
    """The one-shot form, told for each of many outcomes where the least mean is."""
    data, search = observed(8), Search(2)
    model = TruncatedModel.fit(data)
    here = with_source(np.array(gains), source)
    with exact_algebra():
        least, mean = recommend(model, search)
        ends = with_source(np.vstack([search.pool(), data.points, least]), "IS1")
        acquisition = KnowledgeGradient(model, search)
        with torch.no_grad():
            fantasies = SobolQMCNormalSampler(torch.Size([256]), seed=1)
            one_shot = qMultiFidelityKnowledgeGradient(
                model,
                num_fantasies=256,
                sampler=fantasies,
                posterior_transform=ScalarizedPosteriorTransform(torch.tensor([-1.0], dtype=DTYPE)),
                current_value=torch.tensor([-mean], dtype=DTYPE),
            )
            informed = model.fantasize(here, fantasies)
            means = [informed.posterior(some).mean[..., 0] for some in torch.split(ends, 50)]
            told = torch.cat(means, dim=-1)
            gained = float(one_shot(torch.cat([here, ends[told.argmin(dim=-1)]])[None]))
            value = float(acquisition(here[None]).exp())
    assert value == pytest.approx(gained / cost, rel=0.03)


def test_nothing_is_left_to_ask_when_every_gain_was_run() -> None:
    corners = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    data = Observations(
        np.tile(corners, (2, 1)), ("IS1",) * 4 + ("IS2",) * 4, axis(np.tile(corners, (2, 1)))
    )
    with pytest.raises(InputError, match="all candidate gains were run already by IS1, IS2"):
        asked(data, Search(2, snap=np.round))
