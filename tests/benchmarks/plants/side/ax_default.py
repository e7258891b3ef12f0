"""Ax with its default strategy."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.methods.beliefs import seek_finished
from gmfbo.tuning.query.method import Proposal
from tests.benchmarks.plants.side.priced_runs import Vector, least_measured_run, priced

COST = "cost"

SAME = 1e-9
"""Distance in the unit cube within which a run was made at the gains that were asked for."""


@dataclass(eq=False)
class AxDefault:
    """The client of Ax as its guide has it.

    The first runs of the study are attached, and count among those that Ax makes before it models.
    A run that failed keeps the price that it had when Ax was told.

    Attributes
    ----------
    seed : int
        Of its draws.
    client : Client or None
        Of this study; made at the first proposal.
    told : int
        Real runs that it knows.
    waiting : (int, ndarray) or None
        Its trial that is waited for, with the point (d,) in the unit cube.
    """

    seed: int = 0
    name: str = "ax"
    summary: str = "Ax's client with its default strategy"
    reference: str = "Olson et al. 2025, Ax: a platform for adaptive experimentation"
    correction: None = None
    client: Any = None
    told: int = 0
    waiting: tuple[int, Vector] | None = None

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """What Ax asks for, once it knows all real runs."""
        if not any(one.counts for one in state.of("IS1")):
            return seek_finished(state)
        with _quiet():
            self._tell(state)
            asked = self.client.get_next_trials(max_trials=1)
        (number, values), *_ = asked.items()
        point = np.array([float(values[name]) for name in _names(len(state.space))])
        self.waiting = number, point
        return Proposal("IS1", state.hold(point))

    def recommend(self, state: TuningState) -> tuple[Vector, float, float]:
        """The best run by Ax's own model; the least measured cost while it has none."""
        measured = least_measured_run(state)
        if not any(one.counts for one in state.of("IS1")):
            return measured
        with _quiet():
            self._tell(state)
            try:
                values, *_ = self.client.get_best_parameterization(use_model_predictions=True)
            except Exception:  # Ax names no type of its own for a model that is not fitted yet
                return measured
        return (
            np.array([float(values[name]) for name in _names(len(state.space))]),
            measured[1],
            0.0,
        )

    def _tell(self, state: TuningState) -> None:
        """Tell the runs that Ax does not know."""
        points, costs = priced(state)
        if self.client is None:
            self.client = _new_client(len(state.space), self.seed)
        for point, cost in zip(points[self.told :], costs[self.told :], strict=True):
            number = self._number(point)
            self.client.complete_trial(number, raw_data={COST: float(cost)})
        self.told = len(costs)

    def _number(self, point: Vector) -> int:
        """Ax's trial of a run; one that was made elsewhere than Ax had asked is attached."""
        if self.waiting is not None:
            number, asked = self.waiting
            self.waiting = None
            if np.abs(point - asked).max() <= SAME:
                return number
            self.client.mark_trial_abandoned(number)
        values = dict(zip(_names(len(point)), map(float, point), strict=True))
        return int(self.client.attach_trial(values))


def _names(width: int) -> list[str]:
    return [f"gain{column}" for column in range(width)]


def _new_client(width: int, seed: int) -> Any:
    from ax.api.client import Client
    from ax.api.configs import RangeParameterConfig

    client = Client(random_seed=seed)
    client.configure_experiment(
        [RangeParameterConfig(name, (0.0, 1.0), "float") for name in _names(width)]
    )
    client.configure_optimization(objective=f"-{COST}")
    return client


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Ax's lines for each trial."""
    logging.disable(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(logging.NOTSET)
