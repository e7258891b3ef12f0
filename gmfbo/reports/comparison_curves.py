"""What the figures of a comparison of methods show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """A mean over seeds with its 95 % interval; n points.

    Attributes
    ----------
    method : str
        Who made it.
    name : {"objective", "regret", "cost"}
        What it shows.
    x : ndarray, shape (n,)
        Real runs; for the cost, queries.
    mean, low, high : ndarray, shape (n,)
        [dimensionless; the cost in units of a real run]
    seeds : int
        How many are averaged.
    """

    method: str
    name: str
    x: Array
    mean: Array
    low: Array
    high: Array
    seeds: int


@dataclass(frozen=True, eq=False)
class Landscape:
    """Costs over two gains.

    Attributes
    ----------
    names : (str, str)
        The gains.
    x, y : ndarray, shape (n,) and (m,)
        Their values [unit of the gain].
    objective : ndarray, shape (n, m)
        True cost g of the plant.
    error : ndarray, shape (n, m)
        [%] Relative error of the twin's scaled cost G.
    seed : int
        That decides twin and constants.
    """

    names: tuple[str, str]
    x: Array
    y: Array
    objective: Array
    error: Array
    seed: int
