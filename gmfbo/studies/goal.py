"""Goal of a method: its best observed gains are as good as the true optimum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

TOLERANCE = 0.02
"""Simple regret, over the way from the optimum to the median gains, at arrival."""


@dataclass(frozen=True)
class Goal:
    """The true optimum of a plant, and the scale of the simple regret.

    Attributes
    ----------
    least, median : float
        Smallest and median true cost g over the box, dimensionless.
    """

    least: float
    median: float

    @classmethod
    def over(cls, costs: ArrayLike) -> Self:
        """Make the goal from the true costs over the box.

        Parameters
        ----------
        costs : array_like, shape (m,)
            True cost g at points that cover the box densely.
        """
        values = np.asarray(costs, dtype=float)
        return cls(float(values.min()), float(np.median(values)))

    def regret(self, cost: float) -> float:
        """Return (cost - least) / (median - least): 0 at the optimum, 1 at median gains.

        Parameters
        ----------
        cost : float
            True cost g of a run.
        """
        spread = self.median - self.least
        # In a box of mostly equal gains the regret has no scale.
        return (cost - self.least) / spread if spread > 0.0 else float(cost > self.least)


@dataclass(frozen=True)
class Descent:
    """Progress of a study's best real run, one entry a real run.

    Attributes
    ----------
    best : tuple of float
        Least true cost g so far; it starts anew where the plant changes.
    regret : tuple of float
        Simple regret, as a share of the way from the optimum to the median.
    first_counted : int
        First real run, from 1, at which arrival counts: the first on the changed plant.
    """

    best: tuple[float, ...]
    regret: tuple[float, ...]
    first_counted: int = 1

    @classmethod
    def of(
        cls, costs: Sequence[float], goals: Sequence[Goal], change_after: int | None = None
    ) -> Self:
        """Follow the best real run.

        Parameters
        ----------
        costs : sequence of float
            True cost g of each real run, in order.
        goals : sequence of Goal
            Of the plant, and of the changed plant where it changes.
        change_after : int or None
            Real runs before the change.
        """
        best: list[float] = []
        regret: list[float] = []
        for number, cost in enumerate(costs, start=1):
            changed = change_after is not None and number > change_after
            # The best run on the old plant says nothing about the changed plant.
            anew = not best or (changed and number == (change_after or 0) + 1)
            best.append(cost if anew else min(best[-1], cost))
            regret.append(goals[-1 if changed else 0].regret(best[-1]))
        return cls(tuple(best), tuple(regret), 1 if change_after is None else change_after + 1)

    def arrival(self, real_runs: int | None = None) -> int | None:
        """Return n* within `real_runs`: real runs, initial ones included, until regret <= 2 %.

        Returns
        -------
        int or None
            None where the goal was never reached.
        """
        looked_at = self.regret[:real_runs]
        for number, regret in enumerate(looked_at, start=1):
            if number >= self.first_counted and regret <= TOLERANCE:
                return number
        return None
