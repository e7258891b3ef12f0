"""Unknowns of a twin: uncertain parameters and tables as one vector with its prior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gmfbo.retuning.table_prior import TablePrior
from gmfbo.sources.binding.lookup_table import LookupTable, tables_of
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.uncertain import Uncertain, uncertain_of

_RANGES_PER_SPREAD = 4.0
"""A stated range is taken as 95 %: four standard deviations."""


@dataclass(frozen=True)
class Scalar(Uncertain):
    """An uncertain parameter with its prior: its range is four standard deviations wide."""

    @property
    def logarithmic(self) -> bool:
        """Whether the range has one sign, so that it is a range of factors."""
        return self.low > 0.0 and self.nominal > 0.0

    def value(self, x: float) -> float:
        """Value [FMU's unit] at x standard deviations from the nominal one, within the range."""
        if self.logarithmic:
            spread = np.log(self.high / self.low) / _RANGES_PER_SPREAD
            value = self.nominal * np.exp(spread * x)
        else:
            value = self.nominal + (self.high - self.low) / _RANGES_PER_SPREAD * x
        return float(np.clip(value, self.low, self.high))

    def place(self, value: float) -> float:
        """Standard deviations x at which the parameter has a value [FMU's unit] of its range."""
        if self.logarithmic:
            spread = np.log(self.high / self.low) / _RANGES_PER_SPREAD
            return float(np.log(max(value, self.low) / self.nominal) / spread)
        return float((value - self.nominal) * _RANGES_PER_SPREAD / (self.high - self.low))


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Scalars and tables of a twin as a vector x, zero as the twin file has it.

    Scalars come first, in standard deviations of their priors; then the changes of the nodes
    of each table, in standard deviations of their noise.

    Attributes
    ----------
    scalars : tuple of Scalar
        Parameters of [uncertain] and of added physics.
    tables : tuple of LookupTable
        From [tables].
    priors : tuple of TablePrior
        One a table.
    before : tuple of ndarray
        Values of each table's parameters as the twin has them [FMU's unit].
    """

    scalars: tuple[Scalar, ...]
    tables: tuple[LookupTable, ...] = ()
    priors: tuple[TablePrior, ...] = ()
    before: tuple[NDArray[np.float64], ...] = ()

    @classmethod
    def of(cls, twin: FmuTwin) -> Self:
        """Read the unknowns of a twin.

        Parameters
        ----------
        twin : FmuTwin
            Its [uncertain] and [tables].

        Raises
        ------
        SimulationError
            The tables cannot be read: the FMU does not initialise.
        """
        scalars = tuple(Scalar(**vars(uncertain)) for uncertain in uncertain_of(twin))
        tables = tables_of(twin.binding)
        priors, before = [], []
        for table in tables:
            read = twin.values_at_start(table.nodes)
            nodes = np.array([read[name] for name in table.nodes])
            priors.append(TablePrior.of(nodes, table.shape, table.rising))
            before.append(np.array([twin.nominal(name) for name in table.parameters]))
        return cls(scalars, tables, tuple(priors), tuple(before))

    def with_physics(self, added: Sequence[Scalar]) -> Self:
        """Unknowns with parameters of physics after the other scalars."""
        return replace(self, scalars=(*self.scalars, *added))

    @property
    def size(self) -> int:
        """Length of x."""
        return len(self.scalars) + sum(prior.nodes.size for prior in self.priors)

    @property
    def smoothed(self) -> NDArray[np.float64]:
        """Most probable x without any recording, shape (size,)."""
        parts = [np.zeros(len(self.scalars))]
        parts += [prior.smoothing_change / (prior.scale * prior.noise) for prior in self.priors]
        return np.concatenate(parts)

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and largest x, shape (size,) each: a scalar stays in its range, a table is free."""
        tables = self.size - len(self.scalars)
        ends = [
            np.concatenate([[one.place(end) for one, end in ends], np.full(tables, free)])
            for ends, free in (
                ([(one, one.low) for one in self.scalars], -np.inf),
                ([(one, one.high) for one in self.scalars], np.inf),
            )
        ]
        return ends[0], ends[1]

    def settings(self, x: NDArray[np.float64]) -> dict[str, float]:
        """FMU parameters [FMU's unit] at x, shape (size,)."""
        values = {one.name: one.value(x[k]) for k, one in enumerate(self.scalars)}
        for table, prior, before, change in zip(
            self.tables, self.priors, self.before, self.changes(x), strict=True
        ):
            values |= table.settings(prior.nodes, change, before)
        return values

    def prior_rows(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals of the prior; their squares add up to minus twice its logarithm."""
        rows = [x[: len(self.scalars)]]
        rows += [p.rows(change) for p, change in zip(self.priors, self.changes(x), strict=True)]
        return np.concatenate(rows)

    def prior_slope(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of `prior_rows` with respect to x, shape (rows, size)."""
        from scipy.linalg import block_diag

        blocks = [np.eye(len(self.scalars))]
        for prior, change in zip(self.priors, self.changes(x), strict=True):
            blocks.append(prior.slope_of_rows(change) * (prior.scale * prior.noise))
        return np.asarray(block_diag(*blocks))

    def changes(self, x: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Change of the nodes of each table at x [unit of the nodes]."""
        changes, first = [], len(self.scalars)
        for prior in self.priors:
            last = first + prior.nodes.size
            changes.append(x[first:last] * prior.scale * prior.noise)
            first = last
        return changes
