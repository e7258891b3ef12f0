"""Relevance of a run: its information about the least cost of the real axis."""

from __future__ import annotations

import numpy as np
import torch
from botorch.acquisition.cost_aware import InverseCostWeightedUtility
from botorch.acquisition.max_value_entropy_search import qMultiFidelityMaxValueEntropy
from botorch.models.cost import AffineFidelityCostModel
from botorch.utils.sampling import manual_seed
from numpy.typing import NDArray
from torch import Tensor

from gmfbo.acquisition.knowledge_gradient import FIXED_COST, SOURCE_COST
from gmfbo.acquisition.maximise import Search
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.surrogate.observations import IS1, with_source
from gmfbo.surrogate.truncated import TruncatedModel


def information_per_cost(
    model: TruncatedModel, search: Search, point: NDArray[np.float64], source: str, seed: int
) -> float:
    """Mutual information of a run and the axis' least cost, over the cost of the run [nat].

    Max-value entropy search with several fidelities (Takeno et al. 2020, as BoTorch has it),
    for the minimum, with a cost of 0.1 for the twin and 1 for the axis.

    Parameters
    ----------
    model : TruncatedModel
        Posterior of g.
    search : Search
        Box over which the least cost is sampled.
    point : ndarray, shape (d,)
        Gains of the run in the unit cube.
    source : str
        Source of the run.
    seed : int
        Of the samples of the least cost.

    Returns
    -------
    float
        Zero or more; a negative estimate is set to zero.
    """
    cost = AffineFidelityCostModel(
        fidelity_weights={search.dimension: SOURCE_COST}, fixed_cost=FIXED_COST
    )

    def project(inputs: Tensor) -> Tensor:
        return torch.cat([inputs[..., :-1], torch.full_like(inputs[..., -1:], IS1)], dim=-1)

    with exact_algebra(), manual_seed(seed):
        entropy = qMultiFidelityMaxValueEntropy(
            model,
            candidate_set=with_source(search.pool(), "IS1"),
            maximize=False,
            cost_aware_utility=InverseCostWeightedUtility(cost_model=cost.to(DTYPE)),
            project=project,
        )
        with torch.no_grad():
            value = float(entropy(with_source(point, source)[:, None, :]))
    return max(value, 0.0)
