"""What was fitted before any physics was considered: the twin's own values, and the logging."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class EstimatedParameter:
    """An uncertain parameter of the twin, refitted, with its 95 % interval.

    Attributes
    ----------
    nominal : float
        [unit] Value in the twin.
    value : float
        [unit] Refitted value; the nominal one where it is not identifiable.
    unit : str
        Unit that the FMU declares.
    low, high : float
        [unit] Ends of the interval.
    identifiable : bool
        The recordings see it by itself; else it appears in a `Combination`.
    """

    nominal: float
    value: float
    unit: str
    low: float
    high: float
    identifiable: bool = True


@dataclass(frozen=True)
class Combination:
    """A product of powers of parameters that the recordings do see, with its 95 % interval.

    Attributes
    ----------
    expression : str
        In the FMU's names, such as `mech.J / mot.kt`.
    value : float
        Estimate, in the units that the expression gives.
    low, high : float
        Ends of the interval.
    """

    expression: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Alignment:
    """How the logging of one signal was found to be; these are nuisances, never physics.

    Attributes
    ----------
    logged : str
        `held` or `new`: the command still held at t_k, or the one just computed.
    shift : float
        [s] By which the column is late.
    scale : float
        Factor on the column, dimensionless.
    offset : float
        [unit of the signal] Added to the column.
    """

    logged: str
    shift: float
    scale: float
    offset: float
