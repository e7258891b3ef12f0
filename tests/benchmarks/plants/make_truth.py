"""Makes `truth.csv` of each plant: noise-free weighted metrics over the box.

    python -m tests.benchmarks.plants.make_truth [PLANT...] [--points N]

A grid of 41 points a side in two gains, else a Sobol sequence of 20,000 points; then CMA-ES from
the best of them, whose best point is the last row. A plant's file is made once; to make it again,
remove it.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gmfbo.files.durable import write_whole
from tests.benchmarks.plants.catalogue import PLANTS
from tests.benchmarks.plants.evolution import cma_es
from tests.benchmarks.plants.judge import Judge

SIDE, SOBOL = 41, 20_000

GENERATIONS = 40, 100
"""Of CMA-ES: from a grid of two gains, a fortieth of a side apart; from sparser points of more."""


def covering(gains: int, points: int | None) -> NDArray[np.float64]:
    """Points of the unit cube, shape (m, d); the last gain changes fastest in a grid.

    Parameters
    ----------
    gains : int
        d.
    points : int or None
        About how many; None takes those of the published files.
    """
    if gains == 2:
        side = SIDE if points is None else round(points**0.5)
        axis = np.linspace(0.0, 1.0, side)
        return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that 20,000 is no power of two
        return np.asarray(qmc.Sobol(gains, scramble=False).random(points or SOBOL))


def truth_text(judge: Judge, points: int | None = None) -> str:
    """The file: a column a gain, a weighted metric, and the late error.

    Parameters
    ----------
    judge : Judge
        Of the plant.
    points : int or None
        About how many; None takes those of the published files.
    """
    space = judge.gains.space
    at = space.from_unit(covering(len(space), points))
    rows = [judge.weighed(point) for point in at]
    names = list(rows[0])
    table = np.array([[row[name] for name in names] for row in rows])
    constants = judge.study.file.objective.normalise
    if constants.points is None:
        cost = judge.cost(dict(zip(names, table.T, strict=True)))
        best = space.to_unit(at[int(np.argmin(cost))])
        count = GENERATIONS[len(space) > 2]
        found = space.from_unit(
            cma_es(lambda u: judge.true_cost(space.from_unit(u)), best, generations=count)
        )
        at = np.vstack([at, found])
        table = np.vstack([table, [judge.weighed(found)[name] for name in names]])
    lines = [",".join([*space.names, *names])]
    lines += [",".join(f"{v:.8g}" for v in (*p, *r)) for p, r in zip(at, table, strict=True)]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Make the files that are missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plant", nargs="*")
    parser.add_argument("--points", type=int)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    for name in options.plant or PLANTS:
        plant = PLANTS[name]
        path = (options.out or plant.folder) / ("truth.csv" if not options.out else f"{name}.csv")
        if path.exists():
            continue
        with Judge.open(plant) as judge:
            write_whole(path, truth_text(judge, options.points).encode())
        print(path, flush=True)


if __name__ == "__main__":
    main()
