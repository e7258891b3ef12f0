"""What the fitted starts of the axis make of each recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.runs.fitted_start import FittedStart
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations

Array = NDArray[np.float64]


def start_changes(
    simulations: Simulations, point: Point, runs: Sequence[Simulated]
) -> list[list[tuple[Array, ...]]]:
    """[SI] What each fitted start makes of each recording's signals, per spread of its prior.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings, with their starts.
    point : Point
        At which the twin runs; the noise that it plays is left out.
    runs : sequence of Simulated
        The recordings there, without it.
    """
    return changes_by(simulations, simulations.starts, point, runs)


def changes_by(
    simulations: Simulations,
    starts: Sequence[FittedStart],
    point: Point,
    runs: Sequence[Simulated],
) -> list[list[tuple[Array, ...]]]:
    """[SI] Change of each recording's signals by each start, per spread of its prior.

    Parameters
    ----------
    simulations : Simulations
        Of the recordings.
    starts : sequence of FittedStart
        At their values.
    point : Point
        At which the twin runs; the noise that it plays is left out.
    runs : sequence of Simulated
        The recordings there, without it.
    """
    found = []
    for start in starts:
        sizes = start.sizes()
        moved = [value + size for value, size in zip(start.values, sizes, strict=True)]
        point_moved = replace(point, noise=None, own=own_points(point, start.name, moved))
        pairs = zip(simulations.run([point_moved])[0], runs, sizes, strict=True)
        found.append(
            [
                tuple(
                    (a - b) * (start.spread / size) if after.finite else np.zeros_like(b)
                    for a, b in zip(after.signals, before.signals, strict=True)
                )
                for after, before, size in pairs
            ]
        )
    return found


def own_points(point: Point, name: str, values: Sequence[float]) -> list[Point]:
    """A point by recording, with another value of a start in each.

    Parameters
    ----------
    point : Point
        Of all recordings.
    name : str
        Of the start.
    values : sequence of float
        [FMU's unit] By recording.
    """
    return [
        Point(
            {**point.parameters_in(k), name: value},
            point.own[k].physics if point.own else point.physics,
        )
        for k, value in enumerate(values)
    ]
