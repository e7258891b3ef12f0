"""The simplex search of SciPy, from the gains in force."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.query.method import Proposal
from tests.benchmarks.plants.side.priced_runs import Vector, least_measured_run, priced

EDGE = 0.1
"""Edge of the first simplex, as a share of the box: what a gain may move in a first run."""


class _Unanswered(Exception):
    """The search asks for a point that was not run yet."""

    def __init__(self, point: Vector) -> None:
        super().__init__()
        self.point = point.copy()


@dataclass(eq=False)
class NelderMead:
    """Nelder and Mead's simplex; each of its points is a real run, the first the gains in force.

    Before each proposal the search is run again from its start, on the runs that were made. It
    compares costs and does not calculate with them, so that a price which grows changes nothing.

    Attributes
    ----------
    answers : list of int
        Which real run answered each point of the search.
    waiting : int or None
        Number of real runs when the last point was asked for.
    """

    name: str = "nelder_mead"
    summary: str = "SciPy's simplex search from the gains in force"
    reference: str = "Nelder and Mead 1965, A simplex method for function minimization"
    correction: None = None
    answers: list[int] = field(default_factory=lambda: [0])
    waiting: int | None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal | None:
        """The next point of the simplex search; None where it has shrunk to a point."""
        if self.waiting is not None:
            self.answers.append(self.waiting)
        points, costs = priced(state)
        self.waiting = len(costs)
        asked = next_point(points[0], [float(costs[row]) for row in self.answers])
        return None if asked is None else Proposal("IS1", state.hold(asked))

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """The best vertex: the least cost that was measured."""
        return least_measured_run(state)


def next_point(start: Vector, costs: list[float]) -> Vector | None:
    """Point (d,) that the search asks for after these costs, from a start (d,) in the unit cube."""
    edges = np.where(start < 0.5, EDGE, -EDGE)
    simplex = np.vstack([start, start + np.diag(edges)])
    answers = iter(costs)

    def cost(point: Vector) -> float:
        try:
            return next(answers)
        except StopIteration:
            raise _Unanswered(point) from None

    try:
        minimize(
            cost,
            start,
            method="Nelder-Mead",
            bounds=[(0.0, 1.0)] * len(start),
            options={"initial_simplex": simplex, "xatol": 0.0, "fatol": 0.0, "maxfev": 10_000},
        )
    except _Unanswered as asked:
        return asked.point
    return None
