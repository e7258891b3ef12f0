"""From the lines of studies to runs to target, and their statistics."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

Array = NDArray[np.float64]

CAP = 20
"""Real runs after the initial ones up to which a study counts; who never arrives counts as this."""

DRAWS = 4000


def runs_to_target(true: Sequence[float | None], target: float) -> int | None:
    """Real runs after the initial ones from which on the recommendation stays within a target.

    Parameters
    ----------
    true : sequence of float or None
        Noise-free cost of what is recommended right after the initial runs and after each later
        one; None where nothing is, or where it does not settle.
    target : float
        Most cost.

    Returns
    -------
    int or None
        At least 1: a target met right after the initial runs counts as one run. None where the
        last recommendation is not within the target.
    """
    within = [cost is not None and cost <= target for cost in true]
    if not within or not within[-1]:
        return None
    stays = len(within)
    while stays > 0 and within[stays - 1]:
        stays -= 1
    return max(stays, 1)


@dataclass(frozen=True, eq=False)
class Arrivals:
    """Runs to target of methods on plants, on the same seeds.

    Attributes
    ----------
    runs : dict of (str, str) to dict of int to int or None
        By plant and method: by seed, None for never.
    """

    runs: Mapping[tuple[str, str], Mapping[int, int | None]]

    @classmethod
    def of(cls, lines: Sequence[Mapping[str, Any]], targets: Mapping[str, float]) -> Arrivals:
        """Judge lines by the target of each plant.

        Parameters
        ----------
        lines : sequence of mapping
            Of the runner.
        targets : mapping of str to float
            Most cost by plant.
        """
        found: dict[tuple[str, str], dict[int, int | None]] = {}
        for line in lines:
            if line["plant"] in targets:
                seeds = found.setdefault((line["plant"], line["method"]), {})
                seeds[line["seed"]] = runs_to_target(line["true"], targets[line["plant"]])
        return cls(found)

    def capped(self, plant: str, method: str, seeds: Sequence[int]) -> NDArray[np.float64]:
        """Runs to target on these seeds, at most the cap, shape (n,)."""
        known = self.runs[plant, method]
        values = [CAP if known[seed] is None else min(known[seed] or 1, CAP) for seed in seeds]
        return np.array(values, dtype=float)

    def mean(self, plant: str, method: str) -> float:
        """Restricted mean of the runs to target over all seeds of a method on a plant."""
        return float(self.capped(plant, method, sorted(self.runs[plant, method])).mean())

    def geometric_mean(self, plants: Sequence[str], method: str) -> float:
        """The same over some plants, those that the method was run on; NaN without any."""
        have = [plant for plant in plants if self.runs.get((plant, method))]
        logs = [np.log(self.mean(plant, method)) for plant in have]
        return float(np.exp(np.mean(logs))) if logs else float("nan")

    def seeds(self, plant: str, methods: Sequence[str]) -> list[int]:
        """Seeds that all these methods have on a plant."""
        sets = [set(self.runs.get((plant, method), {})) for method in methods]
        return sorted(set.intersection(*sets)) if sets else []

    def never(self, plants: Sequence[str], method: str) -> float:
        """Share of studies that never arrived, pooled over plants; NaN without any."""
        values = [n for p in plants for n in self.runs.get((p, method), {}).values()]
        return float(np.mean([n is None for n in values])) if values else float("nan")


def ratio_of_means(
    arrivals: Arrivals, plants: Sequence[str], method: str, rivals: Sequence[str]
) -> tuple[float, float, float]:
    """Restricted mean of a method over that of its best rival, geometric mean over plants.

    The best rival is one for all plants: that with the least geometric mean; it is chosen anew in
    each draw, so that the choice is part of the uncertainty.

    Returns
    -------
    ratio, low, high : float
        With a 95 % interval by a paired bootstrap over seeds within each plant.
    """
    names = [method, *rivals]
    tables = [
        np.stack([arrivals.capped(plant, name, seeds) for name in names])
        for plant in plants
        if (seeds := arrivals.seeds(plant, names))
    ]

    def ratio(means: Array) -> Array:
        logs = np.log(means).mean(axis=-2)
        return np.asarray(np.exp(logs[..., 0] - logs[..., 1:].min(axis=-1)))

    return _with_interval(tables, ratio)


def never_difference(
    arrivals: Arrivals, plants: Sequence[str], method: str, rivals: Sequence[str]
) -> tuple[float, float, float]:
    """Share of a method's studies that never arrive less that of its best rival, over all plants.

    Returns
    -------
    difference, low, high : float
        With a 95 % interval by a paired bootstrap over seeds within each plant.
    """
    names = [method, *rivals]
    tables = [
        np.array([[arrivals.runs[p, n][s] is None for s in seeds] for n in names], dtype=float)
        for p in plants
        if (seeds := arrivals.seeds(p, names))
    ]
    sizes = np.array([table.shape[1] for table in tables], dtype=float)

    def difference(means: Array) -> Array:
        shares = np.einsum("p,...pm->...m", sizes / sizes.sum(), means)
        return np.asarray(shares[..., 0] - shares[..., 1:].min(axis=-1))

    return _with_interval(tables, difference)


def _with_interval(
    tables: Sequence[Array], statistic: Callable[[Array], Array]
) -> tuple[float, float, float]:
    """A statistic of means, (..., plants, methods) to (...,), of tables (methods, seeds).

    With a 95 % interval by a bootstrap over the seeds of each plant, paired over methods.
    """
    if not tables:
        return (float("nan"),) * 3
    rng = np.random.default_rng(0)
    drawn = []
    for table in tables:
        rows = rng.integers(table.shape[1], size=(DRAWS, table.shape[1]))
        drawn.append(table[:, rows].mean(axis=2).T)
    low, high = np.quantile(statistic(np.stack(drawn, axis=1)), [0.025, 0.975])
    whole = np.stack([table.mean(axis=1) for table in tables])
    return float(statistic(whole)), float(low), float(high)


def clearly_worse(
    arrivals: Arrivals, plants: Sequence[str], method: str, rivals: Sequence[str], by: float
) -> list[tuple[str, str]]:
    """Plants and rivals where a method needs clearly more runs, and by more than a margin.

    One-sided paired t tests on the same seeds, of all plants and rivals together at 5 % (Holm
    1979).

    Parameters
    ----------
    arrivals : Arrivals
        Of all.
    plants, rivals : sequence of str
        That are compared.
    method : str
        Whose runs are asked about.
    by : float
        [runs] Margin.
    """
    found = []
    for plant in plants:
        for rival in rivals:
            seeds = arrivals.seeds(plant, [method, rival])
            more = arrivals.capped(plant, method, seeds) - arrivals.capped(plant, rival, seeds)
            spread = float(more.std(ddof=1)) / np.sqrt(more.size)
            over = float(more.mean()) - by
            p = float(t.sf(over / spread, more.size - 1)) if spread > 0.0 else float(over <= 0.0)
            found.append((p, plant, rival))
    worse = []
    for k, (p, plant, rival) in enumerate(sorted(found)):
        if p > 0.05 / (len(found) - k):
            break
        worse.append((plant, rival))
    return worse


def read_lines(folder: Path) -> list[dict[str, Any]]:
    """All lines of the runner below a folder."""
    files = sorted(folder.glob("*/*.jsonl"))
    return [json.loads(text) for file in files for text in file.read_text("utf-8").splitlines()]
