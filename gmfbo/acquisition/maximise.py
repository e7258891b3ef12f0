"""Maximise the acquisition function, source by source, without repeating a run.

Sources are few and gains continuous, so the gains are optimised for each source and the results
compared. Candidates are a dense grid (one or two gains) or seeded Sobol points (more), and the best
of them improved by BoTorch's optimiser; the same arguments give the same result::

    proposal = maximise(acquisition, Search(dimension=2), sources=("IS1", "IS2"), taken=taken)
    proposal.point (d,), proposal.source, proposal.value
    best = recommend(model, Search(dimension=2))    # least posterior mean of the axis: point, g
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from botorch.acquisition.acquisition import AcquisitionFunction
from botorch.acquisition.analytic import PosteriorMean
from botorch.exceptions.warnings import OptimizationWarning
from botorch.generation.gen import gen_candidates_scipy
from botorch.models.model import Model
from linear_operator.utils.warnings import NumericalWarning
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.acquisition.feasibility import LogWeight, WeightedAcquisition
from gmfbo.correction.torch_setup import DTYPE, exact_algebra
from gmfbo.errors import ExhaustedError, InputError
from gmfbo.space import SAME_POINT
from gmfbo.surrogate.observations import Observations, source_column

Snap = Callable[[NDArray[np.float64]], NDArray[np.float64]]
Admits = Callable[[NDArray[np.float64]], NDArray[np.bool_]]

GRID_SIDE = {1: 401, 2: 41}
SOBOL_POINTS = 1024

NO_VARIANCE = "Negative variance values detected"
"""GPyTorch's warning where a variance is zero to rounding, as at gains that were repeated."""


@dataclass(frozen=True)
class Search:
    """Settings of the search.

    Attributes
    ----------
    dimension : int
        Number of gains d.
    fixed : mapping of int to float
        Columns that are not free, with their value in [0, 1].
    snap : callable, optional
        Moves points of shape (m, d) to the nearest ones that can be run, such as integer gains.
    seed : int
        Seed of the Sobol points; without effect for one or two free gains.
    log_weight : callable, optional
        Log probability, shape (m,), that gains, shape (m, d), meet all limits. It is added to a
        log acquisition, and recommended gains have a probability of at least a half.
    admits : callable, optional
        Tells the points, shape (m, d), at which the axis may be run.
    """

    dimension: int
    fixed: Mapping[int, float] = field(default_factory=dict)
    snap: Snap | None = None
    seed: int = 0
    log_weight: LogWeight | None = None
    admits: Admits | None = None

    def __post_init__(self) -> None:
        for column, value in self.fixed.items():
            if column not in range(self.dimension) or not 0.0 <= value <= 1.0:
                raise InputError(
                    f"expected fixed columns 0..{self.dimension - 1} with values in [0, 1], "
                    f"got {column}: {value}"
                )
        if len(self.fixed) >= self.dimension:
            raise InputError(f"all {self.dimension} gains are fixed; leave one free")

    def log_weights(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Log weight of points, shape (m, d); minus infinity where the axis must not be run."""
        weights = np.zeros(len(points))
        if self.log_weight is not None:
            with torch.no_grad():
                weights += self.log_weight(torch.tensor(points, dtype=DTYPE)).numpy()
        if self.admits is not None:
            weights = np.where(self.admits(points), weights, -np.inf)
        return weights

    def pool(self) -> NDArray[np.float64]:
        """Points that cover the free gains, shape (m, d)."""
        free = [column for column in range(self.dimension) if column not in self.fixed]
        if len(free) in GRID_SIDE:
            axis = np.linspace(0.0, 1.0, GRID_SIDE[len(free)])
            cover = np.stack(np.meshgrid(*[axis] * len(free), indexing="ij"), axis=-1)
            cover = cover.reshape(-1, len(free))
        else:
            cover = qmc.Sobol(d=len(free), rng=self.seed).random(SOBOL_POINTS)
        points = np.empty((len(cover), self.dimension))
        points[:, free] = cover
        for column, value in self.fixed.items():
            points[:, column] = value
        return points


@dataclass(frozen=True, eq=False)
class Proposal:
    """The next query.

    Attributes
    ----------
    point : ndarray, shape (d,)
        Gains in the unit cube.
    source : str
        Source of the query.
    value : float
        Acquisition there; log EI - log H for `CostAwareExpectedImprovement`.
    """

    point: NDArray[np.float64]
    source: str
    value: float


def maximise(
    acquisition: AcquisitionFunction,
    search: Search,
    sources: Sequence[str],
    taken: Observations | None = None,
) -> Proposal:
    """Find the best gains and source that were not run yet.

    Parameters
    ----------
    acquisition : AcquisitionFunction
        Over [gains, source column], to be maximised.
    search : Search
        Settings of the search.
    sources : sequence of str
        Allowed sources; the first one wins at equal value.
    taken : Observations, optional
        Runs made already.

    Raises
    ------
    ExhaustedError
        All candidates of all sources were run already.
    """
    if search.log_weight is not None:
        acquisition = WeightedAcquisition(acquisition, search.log_weight)
    found: list[Proposal] = []
    for source in sources:
        points, values = _candidates(acquisition, search, source)
        if source == "IS1" and search.admits is not None:
            allowed = search.admits(points)
            points, values = points[allowed], values[allowed]
        done = np.empty((0, search.dimension)) if taken is None else taken.points[taken.of(source)]
        for index in np.argsort(-values, kind="stable"):
            if len(done) == 0 or np.abs(done - points[index]).max(axis=1).min() > SAME_POINT:
                found.append(Proposal(points[index], source, float(values[index])))
                break
    if not found:
        raise ExhaustedError(
            f"all candidate gains were run already by {', '.join(sources)}; "
            "widen the box or stop the study"
        )
    return max(found, key=lambda proposal: proposal.value)


def recommend(model: Model, search: Search) -> tuple[NDArray[np.float64], float]:
    """Gains with the least posterior mean: point of shape (d,), and that mean [g].

    Only gains that meet the limits with probability >= 1/2 count; else the most probable ones.
    """
    points, values = _candidates(PosteriorMean(model, maximize=False), search, "IS1")
    weights = search.log_weights(points)
    probable = weights >= min(np.log(0.5), float(weights.max()))
    best = int(np.argmax(np.where(probable, values, -np.inf)))
    return points[best], -float(values[best])


def _candidates(
    acquisition: AcquisitionFunction, search: Search, source: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points of the pool and optimised ones, shape (m, d), and their acquisition, shape (m,)."""
    column = source_column(source)
    snap = search.snap or (lambda points: points)
    pool = np.unique(snap(search.pool()), axis=0)
    values = _evaluate(acquisition, pool, column)
    count = 3 if search.dimension <= 2 else 8
    starts = pool[np.argsort(-values, kind="stable")[:count]]
    polished = snap(_polish(acquisition, starts, column, search.fixed))
    return (
        np.concatenate([polished, pool]),
        np.concatenate([_evaluate(acquisition, polished, column), values]),
    )


def _evaluate(
    acquisition: AcquisitionFunction, points: NDArray[np.float64], column: float
) -> NDArray[np.float64]:
    inputs = torch.tensor(np.hstack([points, np.full((len(points), 1), column)]), dtype=DTYPE)
    with exact_algebra(), torch.no_grad(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=NO_VARIANCE, category=NumericalWarning)
        return np.asarray(acquisition(inputs[:, None, :]).numpy(), dtype=float)


def _polish(
    acquisition: AcquisitionFunction,
    starts: NDArray[np.float64],
    column: float,
    fixed: Mapping[int, float],
) -> NDArray[np.float64]:
    dimension = starts.shape[1]
    initial = np.hstack([starts, np.full((len(starts), 1), column)])
    # The start of a stalled descent stays in the pool, so nothing is lost. BoTorch sets warning
    # filters of its own inside, so its warning is caught rather than filtered.
    with exact_algebra(), warnings.catch_warnings(record=True) as caught:
        polished, _ = gen_candidates_scipy(
            torch.tensor(initial, dtype=DTYPE)[:, None, :],
            acquisition,
            lower_bounds=torch.tensor([0.0] * dimension + [column], dtype=DTYPE),
            upper_bounds=torch.tensor([1.0] * dimension + [column], dtype=DTYPE),
            fixed_features={**fixed, dimension: column},
        )
    for warning in caught:
        known = str(warning.message).startswith(NO_VARIANCE)
        if not known and not issubclass(warning.category, OptimizationWarning):
            warnings.warn(warning.message, stacklevel=2)
    return np.clip(polished[:, 0, :-1].detach().numpy(), 0.0, 1.0)
