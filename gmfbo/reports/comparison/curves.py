"""Data of a comparison's figures."""

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
        Its method.
    name : {"objective", "regret", "cost"}
        Quantity on the y axis.
    x : ndarray, shape (n,)
        Real runs; for the cost, queries.
    mean, low, high : ndarray, shape (n,)
        [dimensionless; the cost in units of a real run]
    seeds : int
        Number of averaged seeds.
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
        Seed of the twin and of the cost's constants.
    """

    names: tuple[str, str]
    x: Array
    y: Array
    objective: Array
    error: Array
    seed: int


@dataclass(frozen=True, eq=False)
class SeedRun:
    """Result of one method on one seed; n real runs.

    Attributes
    ----------
    method : str
        Its name.
    seed : int
        Of the study.
    n_star : int or None
        Real runs until it arrived, initial ones included; None where it never arrived.
    never : int
        Value of n* where it never arrived.
    best, regret : ndarray, shape (n,)
        After each real run: least true cost g, and the simple regret, as a share of the way from
        the optimum to the median gains.
    cost : float
        [real runs] Of all runs.
    twin_runs, corrected_runs : int
        Runs of IS2 and IS3.
    seconds : float
        [s] Wall clock of the whole study.
    """

    method: str
    seed: int
    n_star: int | None
    never: int
    best: Array
    regret: Array
    cost: float
    twin_runs: int
    corrected_runs: int
    seconds: float

    @property
    def counted(self) -> int:
        """n*, or its substitute where the method never arrived."""
        return self.never if self.n_star is None else self.n_star


@dataclass(frozen=True)
class Spread:
    """A statistic over seeds with its 95 % interval.

    Attributes
    ----------
    value, low, high : float
        [unit of the sample]
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class MethodSummary:
    """Result of a method over all its seeds.

    Attributes
    ----------
    method : str
        Its name.
    seeds : int
        Number of seeds.
    median, mean : Spread
        Of n*, real runs until it arrived.
    never : float
        Share of the seeds on which it did not arrive.
    regret : float
        Mean simple regret at the end, as a share of the way from the optimum to the median gains.
    cost : float
        [real runs] Mean cost of all runs.
    seconds : float
        [s] Mean wall clock.
    """

    method: str
    seeds: int
    median: Spread
    mean: Spread
    never: float
    regret: float
    cost: float
    seconds: float


@dataclass(frozen=True, eq=False)
class ComparisonReview:
    """A comparison of methods as it is shown.

    Attributes
    ----------
    name : str
        Of its folder.
    text : str
        Its tables.
    curves : tuple of Curve
        Of all methods.
    landscape : Landscape or None
        None where other than two gains are tuned.
    runs : tuple of SeedRun
        Of every seed; empty where only the tables were kept.
    methods : tuple of MethodSummary
        In the order in which they are shown; empty without runs.
    """

    name: str
    text: str
    curves: tuple[Curve, ...]
    landscape: Landscape | None
    runs: tuple[SeedRun, ...] = ()
    methods: tuple[MethodSummary, ...] = ()
