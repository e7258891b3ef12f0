"""The folder of a comparison as `gmfbo compare` leaves it, in a blink."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gmfbo.reports.comparison.curves import Landscape
from gmfbo.studies.comparison_folder import ComparisonFolder
from tests.studies.small_study import outcome

X, Y = np.linspace(30.0, 200.0, 6), np.linspace(2.0, 10.0, 5)
COSTS = (X[:, None] / 200.0 - 0.7) ** 2 + (Y / 10.0 - 0.4) ** 2
LANDSCAPE = Landscape(("ctl.Kp", "ctl.Kd"), X, Y, COSTS, 100.0 * COSTS, seed=4)

ARRIVALS = {"gmfbo": (3, 2, 4), "bo_ei": (5, None, 4), "random": (None, None, None)}


def write_example_comparison(folder: Path, landscape: Landscape | None = LANDSCAPE) -> Path:
    """Write three methods on three seeds of five real runs.

    Parameters
    ----------
    folder : Path
        Where `joint.compare` is made.
    landscape : Landscape or None
        None leaves it out.
    """
    kept = ComparisonFolder(folder / "joint.compare")
    kept.path.mkdir(parents=True)
    made = []
    for method, arrivals in ARRIVALS.items():
        for seed, n_star in enumerate(arrivals):
            falling = 0.9 ** np.arange(5) * (1.0 + 0.1 * seed)
            regret = np.where(np.arange(1, 6) >= (n_star or 9), 0.001 * seed, falling)
            one = outcome(method, seed, n_star, regret=tuple(map(float, regret)),
                          seconds=(0.5, 0.25, 0.25))  # fmt: skip
            kept.keep(one, None)
            made.append(one)
    kept.write_tables(made, ["$ gmfbo compare joint.toml", "joint, gmfbo 0.1.0"], landscape)
    return kept.path
