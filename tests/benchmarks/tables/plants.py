"""Tables of the benchmark of plants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from tests.benchmarks.plants.arrival import (
    Arrivals,
    never_difference,
    ratio_of_means,
    read_lines,
)
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.run import RESULTS
from tests.benchmarks.plants.table import RIVALS
from tests.benchmarks.plants.targets import read_targets
from tests.benchmarks.tables.tuning import table

WAY = 0.05
OURS = "gmfbo_estimated"
METHODS = (OURS, *RIVALS, "identify_then_optimise")
SHOWN = {
    "drive_twin": "drive, friction",
    "velocity_loop": "velocity loop, delay",
    "two_mass": "elastic shaft",
    "mujoco_belt": "belt, in MuJoCo",
    "pendulum": "pendulum",
}
"""Plants that README tells, and what it calls them: the last two are the worst ones."""


@dataclass(frozen=True)
class Told:
    """What the benchmark says of all plants together.

    Attributes
    ----------
    means : dict of str to float
        Geometric mean of runs to target over the plants, by method.
    never : dict of str to float
        Share of studies that never arrived.
    ratio : tuple of float
        Of ours to the better of those without a twin, with a 95 % interval.
    never_less : tuple of float
        Share of ours that never arrive less that of the best other, with a 95 % interval.
    seeds : int
        Studies of each method on each plant, at least.
    """

    means: dict[str, float]
    never: dict[str, float]
    ratio: tuple[float, float, float]
    never_less: tuple[float, float, float]
    seeds: int


@cache
def arrivals(share: float = WAY) -> Arrivals:
    """Runs to target of all studies.

    Parameters
    ----------
    share : float
        Of the way to the optimum that may be left.
    """
    targets = read_targets()
    return Arrivals.of(read_lines(RESULTS), {n: one.cost(share) for n, one in targets.items()})


@cache
def told(share: float = WAY) -> Told:
    """All plants together."""
    found, plants = arrivals(share), list(PLANTS)
    means = {m: found.geometric_mean(plants, m) for m in METHODS}
    never = {m: found.never(plants, m) for m in METHODS}
    seeds = min(len(found.runs[plant, m]) for plant in plants for m in METHODS)
    ratio = ratio_of_means(found, plants, OURS, RIVALS)
    less = never_difference(found, plants, OURS, [m for m in METHODS if m != OURS])
    return Told(means, never, ratio, less, seeds)


def for_readme() -> str:
    """Five plants, and all of them, at 5 % of the way."""
    found, all_of = arrivals(), told()
    rows = [
        [said, *(f"{found.mean(plant, m):.1f}" for m in METHODS)] for plant, said in SHOWN.items()
    ]
    rows.append(
        [f"all {len(PLANTS)}, geometric mean", *(f"{v:.1f}" for v in all_of.means.values())]
    )
    return table(["axis", *(f"`{m}`" for m in METHODS)], rows)


def every_plant() -> str:
    """All plants at 2, 5 and 10 % of the way: mean, and how many never arrived."""
    rows = []
    by_share = {share: arrivals(share) for share in (0.02, WAY, 0.10)}
    for plant in PLANTS:
        for share, found in by_share.items():
            cells = [_cell(found, plant, m) for m in METHODS]
            rows.append([f"`{plant}`" if share == 0.02 else "", f"{100 * share:.0f} %", *cells])
    for share in by_share:
        one = told(share)
        cells = [f"{one.means[m]:.1f} ({100 * one.never[m]:.0f} %)" for m in METHODS]
        name = "geometric mean (never)" if share == 0.02 else ""
        rows.append([name, f"{100 * share:.0f} %", *cells])
    return table(["plant", "within", *(f"`{m}`" for m in METHODS)], rows)


def _cell(found: Arrivals, plant: str, method: str) -> str:
    runs = found.runs[plant, method]
    never = sum(n is None for n in runs.values())
    return f"{found.mean(plant, method):.1f} ({never})"
