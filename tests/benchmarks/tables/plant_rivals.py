"""The side table of the plants: rivals of others, variants of ours, noise, and an envelope."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.plants import safety, side_table, twin_kinds
from tests.benchmarks.plants.arrival import CAP, Arrivals, read_lines, runs_to_target
from tests.benchmarks.plants.run import RESULTS
from tests.benchmarks.plants.targets import read_targets
from tests.benchmarks.tables.plants import OURS, WAY
from tests.benchmarks.tables.tuning import table

MAIN = (OURS, "bo_ei", "log_ei", "identify_then_optimise")

SAID = {
    "ax": "`ax`, its default strategy",
    "nelder_mead": "`nelder_mead`, from the gains in force",
    "mfbo_takg": "`mfbo_takg`, 2 or 3 seeds",
    "gmfbo_paper": "`gmfbo_paper`",
    "gmfbo_calibrated": "`gmfbo_calibrated`",
    "is3_source": "`gmfbo_estimated`, corrected runs as a third source",
    "is3_none": "`gmfbo_estimated`, no correction of trajectories",
}
"""What the page calls each method of the parts that are compared with the main table."""

TWIN_COST = 0.1
"""Cost of a run of the twin, corrected or not, in real runs: the publication's account."""


def lines_of(*parts: str, folder: Path = side_table.FOLDER) -> list[dict[str, Any]]:
    """All lines of some parts."""
    return [line for part in parts for line in read_lines(folder / part)]


def _arrivals(lines: Sequence[Mapping[str, Any]], share: float = WAY) -> Arrivals:
    targets = read_targets()
    return Arrivals.of(lines, {name: one.cost(share) for name, one in targets.items()})


def seeds_of(lines: Sequence[Mapping[str, Any]]) -> list[int]:
    """Seeds that some lines have, in order."""
    return sorted({int(line["seed"]) for line in lines})


def _main(seeds: Sequence[int]) -> list[dict[str, Any]]:
    """Lines of the main table on the four plants and some seeds."""
    wanted = read_lines(RESULTS)
    return [
        line
        for line in wanted
        if line["plant"] in twin_kinds.CHOSEN and line["seed"] in seeds and line["method"] in MAIN
    ]


def _row(found: Arrivals, method: str) -> list[str]:
    """Runs to target on each of the four plants, their geometric mean, and the share of never."""
    plants = list(twin_kinds.CHOSEN)
    cells = []
    for plant in plants:
        runs = found.runs[plant, method]
        never = sum(n is None for n in runs.values())
        cells.append(f"{found.mean(plant, method):.1f} ({never})")
    mean, never_at_all = found.geometric_mean(plants, method), found.never(plants, method)
    return [*cells, f"{mean:.1f} ({100 * never_at_all:.0f} %)"]


def _heads(first: str) -> list[str]:
    return [first, *(f"`{name}`" for name in twin_kinds.CHOSEN), "geometric mean (never)"]


@cache
def _beside_main() -> Arrivals:
    side = lines_of("rivals", "knowledge_gradient", "is3")
    return _arrivals([*_main(seeds_of(side)), *side])


def mean_of(method: str) -> float:
    """Runs to target of a method, geometric mean over the four plants."""
    return _beside_main().geometric_mean(list(twin_kinds.CHOSEN), method)


def others() -> str:
    """Rivals and variants beside the main table's methods on the same plants and seeds."""
    found = _beside_main()
    rows = [[f"`{name}`", *_row(found, name)] for name in MAIN]
    rows += [[said, *_row(found, name)] for name, said in SAID.items() if _has(found, name)]
    return table(_heads("method"), rows)


def _has(found: Arrivals, method: str) -> bool:
    return all(found.runs.get((plant, method)) for plant in twin_kinds.CHOSEN)


def by_noise() -> str:
    """Ours and two rivals at 0.3, 1 and 3 times the noise."""
    rows = []
    for method in MAIN[:3]:
        for factor in (0.3, 1.0, 3.0):
            lines = (
                _main(seeds_of(lines_of("noise_3")))
                if factor == 1.0
                else lines_of(f"noise_{factor:g}")
            )
            name = f"`{method}`" if factor == 0.3 else ""
            rows.append([name, f"{factor:g}", *_row(_arrivals(lines), method)])
    head = _heads("method")
    return table([head[0], "noise", *head[1:]], rows)


def limited() -> str:
    """Runs to target with an envelope, and runs that left it."""
    lines = lines_of("envelope")
    found, plants = _arrivals(lines), safety.LIMITED
    rows = []
    for method in side_table.PARTS["envelope"].methods:
        cells = []
        for plant in plants:
            gone, count = safety.left(lines, method, [plant])
            cells.append(f"{found.mean(plant, method):.1f}; {gone} of {count}")
        gone, count = safety.left(lines, method, plants)
        mean = found.geometric_mean(plants, method)
        cells.append(f"{mean:.1f}; {100.0 * gone / count:.1f} %")
        rows.append([f"`{method}`", *cells])
    heads = ["with an envelope", *(f"`{name}`" for name in plants), "geometric mean; share"]
    return table(heads, rows)


def costs_to_target(method: str) -> dict[str, float]:
    """Cost until a method's recommendation stays within the target, mean over seeds, by plant.

    The publication's account: a real run counts 1 and a run of the twin 0.1, the initial ones
    included. Who never arrives counts what was spent until the cap.
    """
    targets = read_targets()
    spent: dict[str, list[float]] = {}
    for line in lines_of("rivals", "knowledge_gradient", "is3"):
        if line["method"] != method:
            continue
        arrived = runs_to_target(line["true"], targets[line["plant"]].cost(WAY))
        real = min(line["initial"] + min(arrived or CAP, CAP), len(line["twin_before"]))
        cost = real + TWIN_COST * line["twin_before"][real - 1]
        spent.setdefault(line["plant"], []).append(cost)
    return {plant: float(np.mean(costs)) for plant, costs in spent.items()}
