"""What the final gains of the benchmark are worth elsewhere than they were tuned for.

    python -m tests.benchmarks.plants.robustness [--plants P,Q] > results/robustness.txt

The gains that each study recommends last are run without noise: with an inertia (a mass, a heat
capacity) less or more by 20 %, a friction less or more by 30 %, and along half and twice the step.
Nothing is tuned here, and no study is run.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tests.benchmarks.plants.arrival import read_lines
from tests.benchmarks.plants.catalogue import PLANTS, Plant
from tests.benchmarks.plants.judge import Judge
from tests.benchmarks.plants.run import RESULTS
from tests.benchmarks.plants.targets import read_targets
from tests.benchmarks.plants.truths.conditions import QUIET, Conditions

MACHINES = (
    Conditions(inertia=0.8),
    Conditions(inertia=1.2),
    Conditions(friction=0.7),
    Conditions(friction=1.3),
)
STEPS = (0.5, 2.0)
"""Times the step of the study."""


def along(plant: Plant, times: float) -> Judge:
    """Judge of the plant along another step."""
    study = plant.study()
    (reference,) = study.file.references
    scaled = reference.model_copy(update={"step": times * reference.step})
    return Judge.open(
        plant, replace(study, file=study.file.model_copy(update={"references": (scaled,)}))
    )


def final_gains(lines: Sequence[Mapping[str, Any]]) -> list[np.ndarray]:
    """Gains that are recommended last; studies that recommend none have none."""
    return [np.array(line["recommended"][-1]) for line in lines if line["recommended"][-1]]


def of_plant(plant: Plant, lines: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """By method: share of studies that settle on all machines, cost on the mean and the worst one.

    Costs are told over the way from the textbook's cost to the optimum, 0 at the optimum; along
    another step they cannot be compared, so that there only settling counts.
    """
    target = read_targets()[plant.name]
    way = target.textbook - target.optimum
    judges = [Judge.open(plant, quiet=one) for one in (QUIET, *MACHINES)]
    others = [along(plant, times) for times in STEPS]
    found = {}
    for method in dict.fromkeys(line["method"] for line in lines):
        rows = []
        for gains in final_gains([line for line in lines if line["method"] == method]):
            costs = np.array([judge.true_cost(gains) for judge in judges])
            steps = [np.isfinite(judge.true_cost(gains)) for judge in others]
            above = (costs - target.optimum) / way
            rows.append((np.isfinite(costs).all(), above[0], above.max(), *steps))
        count = sum(line["method"] == method for line in lines)
        table = np.array(rows, dtype=float).reshape(-1, 5)
        settled = table[:, 0] == 1.0
        found[method] = [
            float(settled.sum()) / count,
            *(np.median(table[settled, 1:3], axis=0).tolist() if settled.any() else [np.nan] * 2),
            *(table[:, 3:].sum(axis=0) / count).tolist(),
        ]
    for judge in (*judges, *others):
        judge.close()
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plants", default=",".join(PLANTS))
    names = parser.parse_args().plants.split(",")
    lines = read_lines(RESULTS)
    print("settled: share of all studies whose final gains settle with inertia +-20 % and friction")
    print(
        "+-30 %; mean, worst: their median cost over the way to the optimum, on the mean and on the"
    )
    print("worst of these machines; half, twice: share that settle along half and twice the step")
    print(f"{'':37s} settled     mean    worst     half    twice")
    whole: dict[str, list[list[float]]] = {}
    for name in names:
        found = of_plant(PLANTS[name], [line for line in lines if line["plant"] == name])
        for method, values in found.items():
            print(_row(name, method, values), flush=True)
            whole.setdefault(method, []).append(values)
    for method, rows in whole.items():
        print(_row("mean", method, np.nanmean(np.array(rows), axis=0).tolist()))


def _row(plant: str, method: str, values: Sequence[float]) -> str:
    settled, mean, worst, half, twice = values
    return (
        f"{plant:14s} {method:22s} {100 * settled:5.0f} %   {mean:6.2f}   {worst:6.2f}"
        f"  {100 * half:5.0f} %  {100 * twice:5.0f} %"
    )


if __name__ == "__main__":
    main()
