"""Knowledge gradient over gains and source: how much a run lowers the least expected cost.

KG(k, s) = (min mu(., 1) - E[min mu'(., 1) after a run at (k, s)]) / cost(s),
cost(s) = 0.1 + 0.9 s,

in BoTorch's one-shot form (Wu, Toscano-Palmerin, Frazier and Wilson 2019, taKG; Balandat et al.
2020). A trace would be what a long run tells about shorter ones; with two sources it is empty.
BoTorch's own weighting by cost divides the outcomes that gain and multiplies those that lose, which
doubles what a cheap source seems worth; here the expectation is divided.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import torch
from botorch.acquisition.knowledge_gradient import qMultiFidelityKnowledgeGradient
from botorch.acquisition.objective import ScalarizedPosteriorTransform
from botorch.exceptions.warnings import BadInitialCandidatesWarning, OptimizationWarning
from botorch.optim.optimize import optimize_acqf
from botorch.sampling.normal import SobolQMCNormalSampler
from botorch.utils.sampling import manual_seed
from numpy.typing import NDArray
from torch import Tensor

from gmfbo.acquisition.maximise import SAME_POINT, Proposal, Search, recommend
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.errors import InputError
from gmfbo.surrogate.observations import IS1, Observations, source_column
from gmfbo.surrogate.truncated import TruncatedModel

FIXED_COST, SOURCE_COST = 0.1, 0.9
"""Cost of a run of the twin, and what one of the axis costs beyond it [runs of the axis]."""


@dataclass(frozen=True)
class KnowledgeGradientSettings:
    """Effort of the search.

    Attributes
    ----------
    fantasies : int
        Possible outcomes of a run that are looked at.
    restarts : int
        Points from which the search descends.
    raw_samples : int
        Points among which these are chosen.
    iterations : int
        Most steps of a descent.
    """

    fantasies: int = 64
    restarts: int = 4
    raw_samples: int = 64
    iterations: int = 100


def knowledge_gradient(
    model: TruncatedModel, search: Search, fantasies: int, seed: int
) -> qMultiFidelityKnowledgeGradient:
    """Build the acquisition function of a fitted surrogate: KG before it is divided by the cost.

    Parameters
    ----------
    model : TruncatedModel
        Posterior of g, which is minimised.
    search : Search
        Where the least expected cost is looked for.
    fantasies : int
        Possible outcomes of a run.
    seed : int
        Of their quasi-random draw.
    """
    _, least = recommend(model, search)

    def project(inputs: Tensor) -> Tensor:
        return torch.cat([inputs[..., :-1], torch.full_like(inputs[..., -1:], IS1)], dim=-1)

    return qMultiFidelityKnowledgeGradient(
        model,
        num_fantasies=fantasies,
        sampler=SobolQMCNormalSampler(torch.Size([fantasies]), seed=seed),
        posterior_transform=ScalarizedPosteriorTransform(torch.tensor([-1.0], dtype=DTYPE)),
        current_value=torch.tensor([-least], dtype=DTYPE),
        project=project,
    )


def best_query(
    model: TruncatedModel,
    search: Search,
    sources: tuple[str, ...],
    taken: Observations,
    settings: KnowledgeGradientSettings,
    seed: int,
) -> Proposal:
    """Gains and source with the largest knowledge gradient for their cost.

    Parameters
    ----------
    model : TruncatedModel
        Fitted to all runs.
    search : Search
        Held and rounded gains.
    sources : tuple of str
        Who may be asked.
    taken : Observations
        What was run already; it is not proposed again.
    settings : KnowledgeGradientSettings
        Effort of the search.
    seed : int
        The same seed and model give the same query.

    Raises
    ------
    InputError
        Every candidate was run already.
    """
    with exact_algebra(), manual_seed(seed):
        acquisition = knowledge_gradient(model, search, settings.fantasies, seed)
        found = [
            candidate
            for source in sources
            for candidate in _of_source(acquisition, search, source, settings)
        ]
    new = [
        candidate
        for candidate in found
        if np.abs(taken.points[taken.of(candidate.source)] - candidate.point)
        .max(axis=1, initial=0.0)
        .min(initial=np.inf)
        > SAME_POINT
    ]
    if not new:
        raise InputError(
            f"all candidate gains were run already by {', '.join(sources)}; "
            "widen the box or stop the study"
        )
    return max(new, key=lambda candidate: candidate.value)


def _of_source(
    acquisition: qMultiFidelityKnowledgeGradient,
    search: Search,
    source: str,
    settings: KnowledgeGradientSettings,
) -> list[Proposal]:
    """Where the descents ended, one candidate a restart."""
    column, dimension = source_column(source), search.dimension
    bounds = torch.tensor([[0.0] * (dimension + 1), [1.0] * (dimension + 1)], dtype=DTYPE)
    with warnings.catch_warnings():
        # A descent that stalls is judged by its value beside the others; and where nothing is
        # left to learn all starting values are equal.
        warnings.simplefilter("ignore", OptimizationWarning)
        warnings.simplefilter("ignore", BadInitialCandidatesWarning)
        warnings.filterwarnings("ignore", message="Optimization failed", category=RuntimeWarning)
        inputs, values = optimize_acqf(
            acquisition,
            bounds,
            q=1,
            num_restarts=settings.restarts,
            raw_samples=settings.raw_samples,
            fixed_features={**search.fixed, dimension: column},
            options={"batch_limit": settings.restarts, "maxiter": settings.iterations},
            return_best_only=False,
            retry_on_optimization_warning=False,
        )
    assert values is not None
    points = np.clip(inputs[:, 0, :-1].detach().numpy(), 0.0, 1.0)
    snapped: NDArray[np.float64] = search.snap(points) if search.snap else points
    cost = FIXED_COST + SOURCE_COST * column
    return [
        Proposal(point, source, float(value) / cost)
        for point, value in zip(snapped, values.flatten(), strict=True)
    ]
