"""Prints the tables of the benchmark from what is there.

python -m tests.benchmarks.plants.table [FOLDER]
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.plants.arrival import (
    CAP,
    Arrivals,
    clearly_worse,
    never_difference,
    ratio_of_means,
    read_lines,
)
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.run import METHODS, RESULTS
from tests.benchmarks.plants.targets import SHARES, Target, read_targets

OURS, RIVALS = ("gmfbo_physics", "gmfbo_estimated"), ("bo_ei", "log_ei")
MARGIN = 1.5
"""[runs] By which a method may be slower on a plant."""


def tables(lines: Sequence[Mapping[str, Any]], targets: Mapping[str, Target]) -> str:
    """All tables as text.

    Parameters
    ----------
    lines : sequence of mapping
        Of the runner.
    targets : mapping of str to Target
        By plant.
    """
    methods = [m for m in METHODS.split(",") if any(line["method"] == m for line in lines)]
    counted = [name for name in PLANTS if name in targets and targets[name].counts]
    parts = [_plants(targets)]
    for share in SHARES:
        aims = {name: target.cost(share) for name, target in targets.items()}
        arrivals = Arrivals.of(lines, aims)
        parts.append(_at(share, arrivals, methods, list(aims), counted))
    parts.append(_costs(lines, methods))
    return "\n\n".join(parts) + "\n"


def _plants(targets: Mapping[str, Target]) -> str:
    rows = ["plant          optimum textbook by        box within 2, 5, 10 %      noise"]
    for name, one in targets.items():
        shares = " ".join(f"{100 * share:7.2f} %" for share in one.shares.values())
        mark = "" if one.counts else "  not counted"
        rows.append(
            f"{name:14s} {one.optimum:7.3f} {one.textbook:8.3f} {one.by:9s} {shares} "
            f"{one.noise:8.2f}{mark}"
        )
    return "\n".join([*rows, "noise: of one run's cost at the optimum, over the way of 5 %"])


def _at(
    share: float,
    arrivals: Arrivals,
    methods: Sequence[str],
    plants: Sequence[str],
    counted: Sequence[str],
) -> str:
    width = max(map(len, methods), default=0) + 2
    head = f"runs to target at {100 * share:.0f} %, restricted mean (cap {CAP}); never"
    rows = [head, " " * 15 + "".join(f"{m:>{width}s}" for m in methods)]
    for plant in plants:
        cells = [_cell(arrivals, plant, method) for method in methods]
        rows.append(f"{plant:15s}" + "".join(f"{cell:>{width}s}" for cell in cells))
    found = [arrivals.geometric_mean(counted, method) for method in methods]
    means = ["" if np.isnan(mean) else f"{mean:.2f}" for mean in found]
    rows.append(f"{'geometric mean':15s}" + "".join(f"{cell:>{width}s}" for cell in means))
    nevers = [f"{100 * arrivals.never(counted, method):.0f} %" for method in methods]
    rows.append(f"{'never, pooled':15s}" + "".join(f"{cell:>{width}s}" for cell in nevers))
    known = [name for name in RIVALS if name in methods]
    for own in [name for name in OURS if name in methods and known]:
        ratio, low, high = ratio_of_means(arrivals, counted, own, known)
        rows.append(
            f"{own} over the better of {', '.join(known)}: {ratio:.2f} [{low:.2f}, {high:.2f}]"
        )
        others = [name for name in methods if name not in OURS]
        more, least, most = (100.0 * v for v in never_difference(arrivals, counted, own, others))
        rows.append(f"never, less the best other's: {more:.0f} [{least:.0f}, {most:.0f}] points")
        worse = clearly_worse(arrivals, counted, own, others, MARGIN)
        told = ", ".join(f"{plant} ({rival})" for plant, rival in worse) or "none"
        rows.append(f"plants on which it needs clearly more than {MARGIN:g} runs more: {told}")
    return "\n".join(rows)


def _cell(arrivals: Arrivals, plant: str, method: str) -> str:
    found = arrivals.runs.get((plant, method))
    if not found:
        return ""
    never = sum(n is None for n in found.values())
    return f"{arrivals.mean(plant, method):.1f} {never}/{len(found)}"


def _costs(lines: Sequence[Mapping[str, Any]], methods: Sequence[str]) -> str:
    rows = [
        "a study       processor [s]  wall [s]  motion [s]  twin runs  failed  unsafe  unsettled"
    ]
    for method in methods:
        own = [line for line in lines if line["method"] == method]
        count = {
            status: np.mean([line["status"].count(status) for line in own])
            for status in ("failed", "unsafe", "unsettled")
        }
        mean = {
            key: np.mean([line[key] for line in own])
            for key in ("processor_s", "seconds", "motion_s", "twin_runs")
        }
        rows.append(
            f"{method:22s} {mean['processor_s']:8.1f} {mean['seconds']:9.1f} "
            f"{mean['motion_s']:11.1f} {mean['twin_runs']:10.0f} {count['failed']:7.1f} "
            f"{count['unsafe']:7.1f} {count['unsettled']:10.1f}"
        )
    hours = sum(line["processor_s"] + line["recommend_seconds"] for line in lines) / 3600.0
    return "\n".join([*rows, f"{len(lines)} studies, {hours:.2f} core-hours"])


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=RESULTS)
    print(tables(read_lines(parser.parse_args().folder), read_targets()), end="")


if __name__ == "__main__":
    main()
