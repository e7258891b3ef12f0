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

STARTS, APART = 3, 0.1
"""Starts of CMA-ES, and how far they are apart: a landscape of these plants has several valleys."""


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
    if judge.study.file.objective.normalise.points is None:
        at, table = with_best(judge, at, dict(zip(names, table.T, strict=True)))
    lines = [",".join([*space.names, *names])]
    lines += [",".join(f"{v:.8g}" for v in (*p, *r)) for p, r in zip(at, table, strict=True)]
    return "\n".join(lines) + "\n"


def with_best(
    judge: Judge, at: NDArray[np.float64], columns: dict[str, NDArray[np.float64]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gains and values with a last row: the best that CMA-ES finds from several of the others.

    Parameters
    ----------
    judge : Judge
        Of the plant.
    at : ndarray, shape (m, d)
        Gains [unit of each].
    columns : dict of str to ndarray, shape (m,)
        Weighted metrics and late error there.
    """
    space = judge.gains.space
    unit, cost = space.to_unit(at), judge.cost(columns)
    starts: list[int] = []
    for row in np.argsort(cost, kind="stable"):
        apart = [np.abs(unit[row] - unit[other]).max() > APART for other in starts]
        if all(apart) and len(starts) < STARTS and np.isfinite(cost[row]):
            starts.append(int(row))
    count = GENERATIONS[len(space) > 2]
    found = [
        space.from_unit(
            cma_es(
                lambda u: judge.true_cost(space.from_unit(u)),
                unit[row],
                generations=count,
                seed=number,
            )
        )
        for number, row in enumerate(starts)
    ]
    best = min(found, key=judge.true_cost)
    last = judge.weighed(best)
    table = np.stack(list(columns.values()), axis=1)
    return np.vstack([at, best]), np.vstack([table, [last[name] for name in columns]])


def refine(judge: Judge, path: Path) -> None:
    """Seek a better best of a truth file; the better of both is its last row."""
    names, _, rest = path.read_text(encoding="utf-8").partition("\n")
    rows = np.loadtxt(rest.splitlines(), delimiter=",", ndmin=2)
    count, heads = len(judge.gains.space), names.split(",")
    columns = dict(zip(heads[count:], rows[:, count:].T, strict=True))
    at, table = with_best(judge, rows[:, :count], columns)
    before, after = judge.cost(dict(zip(heads[count:], table.T, strict=True)))[[-2, -1]]
    print(f"{path.parent.name}: {before:.4f} -> {min(before, after):.4f}", flush=True)
    if after < before:
        last = ",".join(f"{v:.8g}" for v in (*at[-1], *table[-1]))
        lines = rest.splitlines()[:-1]
        write_whole(path, ("\n".join([names, *lines, last]) + "\n").encode())


def main() -> None:
    """Make the files that are missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plant", nargs="*")
    parser.add_argument("--points", type=int)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--refine", action="store_true", help="seek better gains than the best")
    options = parser.parse_args()
    for name in options.plant or PLANTS:
        plant = PLANTS[name]
        path = (options.out or plant.folder) / ("truth.csv" if not options.out else f"{name}.csv")
        if options.refine and path.exists():
            with Judge.open(plant) as judge:
                refine(judge, path)
            continue
        if path.exists():
            continue
        with Judge.open(plant) as judge:
            write_whole(path, truth_text(judge, options.points).encode())
        print(path, flush=True)


if __name__ == "__main__":
    main()
