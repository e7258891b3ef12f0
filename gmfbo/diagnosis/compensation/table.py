"""One diagnosed effect as a table that a drive can look up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]

TARGETS = ("torque", "command", "reference")
"""Signals to which a compensation may be added."""


@dataclass(frozen=True, eq=False)
class CompensationTable:
    """Straight lines between nodes; beyond the ends the value stays constant or repeats.

    Attributes
    ----------
    effect : str
        Effect that it cancels.
    target : str
        One of TARGETS: the signal to which the value is added.
    over : str
        State that is looked up: velocity, position, acceleration or command.
    x, y : ndarray, shape (n,)
        [unit_x], rising, and [unit_y]
    unit_x, unit_y : str
        As the twin's FMU spells them.
    factor : str
        What its value is multiplied by: nothing where empty, the smoothed sign of the velocity
        (`direction`), the `current` with its sign, or the amount of `load`.
    rest : float
        [velocity] Half width over which the sign of the velocity rises from -1 to 1.
    period : float
        [unit_x] After which the table repeats; 0 where it does not.
    remark : str
        Part of the effect that the table cannot cancel, one sentence; else empty.
    """

    effect: str
    target: str
    over: str
    x: Column
    y: Column
    unit_x: str
    unit_y: str
    factor: str = ""
    rest: float = 0.0
    period: float = 0.0
    remark: str = ""

    @property
    def states(self) -> tuple[str, ...]:
        """States that it needs; the state that is looked up comes first."""
        more = {"": (), "direction": ("velocity",), "current": ("current",), "load": ("load",)}
        return (self.over, *more[self.factor])

    def value(self, states: Mapping[str, Column]) -> Column:
        """Look the compensation up.

        Parameters
        ----------
        states : mapping of str to ndarray, shape (n,)
            Those of `states`.

        Returns
        -------
        ndarray, shape (n,)
            To add to the target.
        """
        at = np.asarray(states[self.over], dtype=np.float64)
        if self.period:
            at = at - self.period * np.floor(at / self.period)
        found = np.interp(at, self.x, self.y)
        return np.asarray(found * self._factor(states), dtype=np.float64)

    def _factor(self, states: Mapping[str, Column]) -> Column | float:
        if self.factor == "direction":
            return np.clip(states["velocity"] / self.rest, -1.0, 1.0)
        if self.factor == "current":
            return states["current"]
        return np.abs(states["load"]) if self.factor == "load" else 1.0


@dataclass(frozen=True)
class NotCompensated:
    """An effect that a feed-forward cannot cancel.

    Attributes
    ----------
    effect : str
        Its name.
    advice : str
        What to do instead, a sentence without its full stop.
    """

    effect: str
    advice: str


@dataclass(frozen=True, eq=False)
class Compensation:
    """Feed-forward for the drive, from a diagnosis.

    Attributes
    ----------
    diagnosis : str
        Folder of the diagnosis.
    tables : tuple of CompensationTable
        One an effect; one with two terms has two.
    not_compensated : tuple of NotCompensated
        Effects without a table.
    units : mapping of str to str
        Unit of each state and target, as the twin's FMU spells it.
    remarks : tuple of str
        For the header.
    """

    diagnosis: str
    tables: tuple[CompensationTable, ...]
    not_compensated: tuple[NotCompensated, ...]
    units: Mapping[str, str]
    remarks: tuple[str, ...] = ()

    @property
    def targets(self) -> tuple[str, ...]:
        """Signals to which compensating values are added."""
        return tuple(t for t in TARGETS if any(table.target == t for table in self.tables))

    def of(self, target: str) -> tuple[CompensationTable, ...]:
        """Tables whose values are added to one target.

        Parameters
        ----------
        target : str
            One of `targets`.
        """
        return tuple(table for table in self.tables if table.target == target)

    def value(self, target: str, states: Mapping[str, Column]) -> Column:
        """Sum of the tables of one target.

        Parameters
        ----------
        target : str
            One of `targets`.
        states : mapping of str to ndarray, shape (n,)
            [units] All that its tables need.

        Returns
        -------
        ndarray, shape (n,)
            To ADD to the target, so that the left-out physics is cancelled.
        """
        values = [table.value(states) for table in self.of(target)]
        return np.asarray(np.sum(values, axis=0), dtype=np.float64)
