"""Landscape: the true objective over the box, and the twin's error, as text."""

from __future__ import annotations

import tempfile
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from gmfbo.errors import StoreError
from gmfbo.objective.cost import Objective
from gmfbo.reports.comparison.curves import Landscape
from gmfbo.studies.one_run import seeded
from gmfbo.studies.plant_grid import TrueSources
from gmfbo.tuning.methods import find_method
from gmfbo.tuning.study.study import Study
from gmfbo.tuning.tuner import Tuner


def landscape_of(study: Study, seed: int, side: int, truth: Path) -> Landscape | None:
    """Cost of the plant over two gains, and the twin's error of it, on one seed.

    Parameters
    ----------
    study : Study
        As given.
    seed : int
        Seed of the twin and of the cost's constants.
    side : int
        Points along a side.
    truth : Path
        Folder of the grids of plant and twin.

    Returns
    -------
    Landscape or None
        None where other than two gains are tuned, or where the truth is given. A plant that
        changes is shown before its change.
    """
    same = seeded(study, seed, study.file.method, study.location)
    opened = TrueSources.open(same)
    with closing(opened.sources):
        if len(opened.gains.space) != 2 or opened.given is not None:
            return None
        plant, twin = (
            opened.grid(source, side, truth) for source in (opened.plants[0], opened.sources.is2)
        )
    objective = _cost(same)
    real, simulated = objective.scaled(plant.metrics), objective.scaled(twin.metrics)
    shape = (side, side)
    return Landscape(
        names=(plant.names[0], plant.names[1]),
        x=plant.points[:, 0].reshape(shape)[:, 0],
        y=plant.points[:, 1].reshape(shape)[0],
        objective=np.asarray(objective.value(plant.metrics)).reshape(shape),
        # The relative error uses G, which is never negative, since g crosses zero.
        error=100.0 * np.abs(simulated - real).reshape(shape) / real.reshape(shape),
        seed=seed,
    )


def _cost(study: Study) -> Objective:
    """Cost with constants by the twin's initial runs on this seed."""
    ended = study.file.budget.model_copy(update={"iterations": 0, "is1_runs": None})
    file = study.file.model_copy(update={"budget": ended, "method": "random"})
    with tempfile.TemporaryDirectory(prefix="gmfbo-") as place:
        begun = replace(study, file=file, location=Path(place) / "run.study")
        with Tuner(begun, method=find_method("random")) as tuner:
            tuner.run()
            return tuner.history.objective


def landscape_text(landscape: Landscape) -> str:
    """Write a landscape as a table, a line a point.

    Parameters
    ----------
    landscape : Landscape
        Result of `landscape_of`.
    """
    lines = [
        f"# seed {landscape.seed}; error: |G of the twin - G of the plant| / G of the plant [%]",
        " ".join([*landscape.names, "objective", "error"]),
    ]
    for i, x in enumerate(landscape.x):
        for j, y in enumerate(landscape.y):
            objective, error = landscape.objective[i, j], landscape.error[i, j]
            lines.append(f"{x:.6g} {y:.6g} {objective:.5g} {error:.4g}")
    return "\n".join(lines) + "\n"


def read_landscape(path: Path) -> Landscape | None:
    """Read a table written by `landscape_text`; None where there is no such file.

    Parameters
    ----------
    path : Path
        A text file.

    Raises
    ------
    StoreError
        It is no table of a landscape.
    """
    if not path.exists():
        return None
    try:
        text = path.read_text(encoding="utf-8")
        first, head, *rows = text.splitlines()
        x, y, objective, error = np.array([row.split() for row in rows], dtype=float).T
        names = head.split()[:2]
        seed = int(first.removeprefix("# seed ").partition(";")[0])
        across, along = np.unique(x), np.unique(y)
        shape = (across.size, along.size)
        return Landscape(
            names=(names[0], names[1]),
            x=across,
            y=along,
            objective=objective.reshape(shape),
            error=error.reshape(shape),
            seed=seed,
        )
    except (OSError, ValueError, IndexError):
        raise StoreError(
            f"{path}: expected the landscape of a comparison; remove it and repeat the comparison"
        ) from None
