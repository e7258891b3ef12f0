"""Estimates beside the physics: the twin's own parameters, and alignment of the signals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gmfbo.diagnosis.result.certainty import CANNOT_TELL
from gmfbo.plain_words import probability

Side = Literal["low", "high"]
"""End of a range."""


@dataclass(frozen=True)
class EstimatedParameter:
    """An uncertain or freed parameter of the twin, refitted, with its 95 % interval.

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
        Whether the recordings determine it alone; else it appears in a `Combination`.
    at_bound : {"low", "high"} or None
        End of its range at which it lies, or beyond which where the range is too narrow.
    bound : float
        [unit] That end; NaN where it is at none.
    stated : str
        Where the range stands, or the value of a fixed parameter: twin file and line.
    fixed : bool
        Whether the twin file holds it fixed, and the recordings contradict that.
    drifts : mapping of str to float, or None
        [unit] Its value in each recording, where these differ by more than chance.
    set : tuple of str
        Of a fixed one: `parameter:NAME` of itself and of those that the recordings cannot tell from
        it. Empty for an uncertain one.
    probability : float or None
        Of a fixed one: that it, or another one of its set, is wrong.
    """

    nominal: float
    value: float
    unit: str
    low: float
    high: float
    identifiable: bool = True
    at_bound: Side | None = None
    bound: float = math.nan
    stated: str = ""
    fixed: bool = False
    drifts: Mapping[str, float] | None = None
    set: tuple[str, ...] = ()
    probability: float | None = None

    @property
    def is_beyond(self) -> bool:
        """Whether the recordings ask for a value beyond the range."""
        return self.value > self.bound if self.at_bound == "high" else self.value < self.bound

    @property
    def is_moved(self) -> bool:
        """Whether the interval leaves out the value in the twin."""
        return not self.low <= self.nominal <= self.high

    @property
    def where_fixed(self) -> str:
        """Words for the line that holds it fixed, and for what else may be wrong in its place.

        Empty for an uncertain one.
        """
        if not self.fixed:
            return ""
        # Without a line the twin file says nothing of it, and the value is the FMU's own.
        own = f"the FMU; [parameters] of {self.stated} sets it"
        stated = self.stated if ", line " in self.stated else own
        others = [name.removeprefix("parameter:") for name in self.set[1:]]
        rivals = f"; or {' or '.join(others)} is wrong, {CANNOT_TELL}" if others else ""
        sure = "" if self.probability is None else f"; probability {probability(self.probability)}"
        return f" (fixed in {stated}{rivals}{sure})"


@dataclass(frozen=True)
class Combination:
    """An identifiable product of powers of parameters, with its 95 % interval.

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
    """Nuisances of one signal's logging as estimated; never physics.

    Attributes
    ----------
    logged : str
        `held` or `new`: the command still held at t_k, or the one just computed.
    shift : float
        [s] Delay of the column.
    scale : float
        Factor on the column, dimensionless.
    offset : float
        [unit of the signal] Added to the column.
    rival : str or None
        A law that would explain as well what is off by most; None where none would, or where
        nothing is off by more than its prior allows.
    beyond_prior : mapping of str to float
        Kinds (`shift`, `scale`, `offset`) of which there is more than the prior allows, each in
        its standard deviations.
    """

    logged: str
    shift: float
    scale: float
    offset: float
    rival: str | None = None
    beyond_prior: Mapping[str, float] = field(default_factory=dict)
