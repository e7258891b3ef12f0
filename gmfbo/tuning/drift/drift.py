"""Drift: detect that the plant changed while it was tuned, and since when.

The real runs are read in their order. A run that does not fit the earlier ones raises the evidence
of a change (`gmfbo.tuning.drift.change_point`); evidence of 1 / FALSE_ALARM_RATE counts as a
change. Earlier runs are then trusted less, never forgotten: the noise variance of their costs grows
by the variance of the change, and the search starts anew from later runs. All follows from the runs
on disk alone, so a resumed study finds the same changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.drift.change_point import (
    FALSE_ALARM_RATE,
    LEAST_BEFORE,
    LEAST_SINCE,
    ChangeEvidence,
    combined,
    log_statistic,
)
from gmfbo.tuning.experiment.run_values import RunValues


@dataclass(frozen=True)
class Drift:
    """A change of the plant.

    Attributes
    ----------
    found_at : int
        Number of real runs, initial ones included, when the change was noticed.
    after_runs : int
        Likeliest number of real runs before the change.
    last_before : int
        Trial number of the last run before the change.
    evidence : float
        Shiryaev-Roberts statistic; without a change it exceeds x in n runs with a probability
        of at most n / x.
    sign : str
        Value in which the change shows most.
    share : float
        Variance of the change, over the variance of that value across the gains.
    """

    found_at: int
    after_runs: int
    last_before: int
    evidence: float
    sign: str
    share: float

    @classmethod
    def logged(cls, event: dict[str, Any]) -> Self:
        """Read a drift from a line of the study's log.

        Parameters
        ----------
        event : dict
            Fields by name.
        """
        return cls(**{name: event[name] for name in cls.__dataclass_fields__})

    @property
    def message(self) -> str:
        """Message for the user."""
        return (
            f"the plant has changed after real run {self.after_runs}, noticed at run "
            f"{self.found_at} by its {self.sign} (odds {self.evidence:.3g} to 1): older runs "
            "count less, and the best is sought among the runs since"
        )


def first_drift(
    points: NDArray[np.float64], series: Sequence[RunValues], numbers: Sequence[int], start: int
) -> Drift | None:
    """Weigh the evidence at the newest run.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Gains of the real runs in the unit cube, in order.
    series : sequence of RunValues
        Values of these runs.
    numbers : sequence of int
        Their trial numbers.
    start : int
        Number of real runs before the last change found; they are left out.

    Returns
    -------
    Drift or None
        None where the newest run gives no evidence of a change.
    """
    count = len(points)
    if count - start < LEAST_BEFORE + LEAST_SINCE:
        return None
    weighed = [_weigh(points, one, start, count) for one in series]
    if not weighed:
        return None  # no run has ended well
    together = combined([ratios for ratios, _ in weighed])[: 1 - LEAST_SINCE]
    together[: LEAST_BEFORE - 1] = -np.inf
    statistic = log_statistic(together)
    if statistic < -np.log(FALSE_ALARM_RATE):
        return None
    change = int(np.argmax(together))
    sign = int(np.argmax([ratios[change] for ratios, _ in weighed]))
    return Drift(
        found_at=count,
        after_runs=start + change + 1,
        last_before=int(numbers[start + change]),
        evidence=float(np.exp(min(statistic, 700.0))),
        sign=series[sign].name,
        share=float(weighed[sign][1][change]),
    )


def _weigh(
    points: NDArray[np.float64], series: RunValues, start: int, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Log ratio and share for a change after each run from `start` on, shape (count-start-1,).

    A change between two runs that have no value counts as one after the last that has.
    """
    kept = (series.rows >= start) & (series.rows < count)
    rows, values = series.rows[kept], series.values[kept]
    found = ChangeEvidence.of(np.ascontiguousarray(points[rows]), values)
    ratios, shares = np.zeros(count - start - 1), np.ones(count - start - 1)
    for place, after in enumerate(range(start + 1, count)):
        before = int(np.sum(rows < after))
        if 0 < before < len(rows):
            ratios[place] = found.log_ratios[before - 1]
            shares[place] = found.shares[before - 1]
    return ratios, shares
