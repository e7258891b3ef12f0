"""What counts as arrived on each plant: the optimum, and the way to it from the textbook.

    python -m tests.benchmarks.plants.targets [PLANT...]

writes `targets.json` from `truth.csv` of each plant, from the rule's gains and from twenty noisy
runs at the optimum.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.files.durable import write_whole
from gmfbo.tuning.study.playing import play
from tests.benchmarks.plants.axis import PlantAxis
from tests.benchmarks.plants.catalogue import HERE, PLANTS
from tests.benchmarks.plants.judge import Judge

FILE = HERE / "targets.json"
SHARES = (0.02, 0.05, 0.10)
"""Of the way from the textbook's objective to the optimum that may be left at arrival."""

MOST_OF_BOX = 0.05
"""Share of the box beyond which a target at 5 % tells nothing; such a plant is not counted."""

NOISY_RUNS = 20


@dataclass(frozen=True)
class Target:
    """Scale of one plant.

    Attributes
    ----------
    optimum, textbook : float
        Least noise-free cost g, and that of the textbook's gains.
    by : str
        `rule`, or `quartile` of the settled gains of the box where no rule fits or settles.
    shares : dict of str to float
        Share of the box within each target.
    noise : float
        Standard deviation of the cost of one run at the optimum, over the way of the 5 % target.
    best : list of float
        Gains of the optimum.
    """

    optimum: float
    textbook: float
    by: str
    shares: dict[str, float]
    noise: float
    best: list[float]

    def cost(self, share: float) -> float:
        """Most cost g at arrival, for a share of the way."""
        return self.optimum + share * (self.textbook - self.optimum)

    @property
    def counts(self) -> bool:
        """Whether the plant is counted in the means over plants."""
        return self.shares["0.05"] <= MOST_OF_BOX


def read_truth(text: str) -> dict[str, NDArray[np.float64]]:
    """Columns of a truth file's content by name, shape (m,)."""
    names, *rows = text.splitlines()
    return dict(zip(names.split(","), np.loadtxt(rows, delimiter=",", ndmin=2).T, strict=True))


def target_of(judge: Judge, text: str | None = None) -> Target:
    """Scale of a plant whose truth has been made.

    Parameters
    ----------
    judge : Judge
        Of the plant.
    text : str, optional
        Its truth file's content, in place of that of its folder.
    """
    from tests.benchmarks.plants.rules import quiet_rule_gains

    truth = read_truth(text or (judge.plant.folder / "truth.csv").read_text(encoding="utf-8"))
    cost = judge.cost(truth)
    row = int(np.argmin(cost))
    best = np.array([truth[name][row] for name in judge.gains.space.names])
    least, settled = float(cost[row]), cost[np.isfinite(cost)]
    gains = quiet_rule_gains(judge)
    textbook, by = (np.inf, "rule") if gains is None else (judge.true_cost(gains), "rule")
    # A rule beyond which nothing is left to gain gives no scale either.
    if not np.isfinite(textbook) or textbook <= least:
        textbook, by = float(np.quantile(settled, 0.25)), "quartile"
    way = 0.05 * (textbook - least)
    shares = {f"{s:.2f}": float(np.mean(cost <= least + 20.0 * s * way)) for s in SHARES}
    return Target(least, textbook, by, shares, noise_at(judge, best) / way, best.tolist())


def noise_at(judge: Judge, point: NDArray[np.float64]) -> float:
    """Standard deviation of the cost of noisy runs at gains (d,)."""
    axis, costs = PlantAxis(judge.plant, seed=1_000_003), []
    rng = np.random.default_rng(0)
    noise = judge.study.file.is1.noise
    for _ in range(NOISY_RUNS):
        run = play(axis, judge.gains.values(point), judge.experiment)
        added = {n: d * rng.standard_normal(len(run.time)) for n, d in noise.items()}
        signals = {n: values + added.get(n, 0.0) for n, values in run.signals.items()}
        run = replace(run, signals=signals)
        metrics = judge.experiment.metrics(run)
        weighed = {name: np.asarray(metrics[name]) for name in judge.weights}
        costs.append(float(judge.cost({**weighed, "late_error": np.zeros(())})))
    axis.close()
    return float(np.std(costs, ddof=1))


def read_targets() -> dict[str, Target]:
    """Targets of all plants that have one."""
    raw: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    return {name: Target(**values) for name, values in raw.items()}


def main() -> None:
    """Write the targets of the plants named, or of all whose truth is there."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plant", nargs="*")
    known = read_targets()
    for name in parser.parse_args().plant or PLANTS:
        if not (PLANTS[name].folder / "truth.csv").exists():
            continue
        with Judge.open(PLANTS[name]) as judge:
            known[name] = one = target_of(judge)
        print(f"{name}: {one}", flush=True)
    raw = {name: asdict(known[name]) for name in PLANTS if name in known}
    write_whole(FILE, (json.dumps(raw, indent=1) + "\n").encode())


if __name__ == "__main__":
    main()
