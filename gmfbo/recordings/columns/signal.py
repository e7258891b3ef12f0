"""Conversion of a recorded column to a signal in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable


@dataclass(frozen=True)
class SignalSpec:
    """One signal of a twin file and its recorded column: value = scale * column + offset.

    Attributes
    ----------
    name : str
        The user's name for the signal.
    column : str
        Name of the recorded column; the signal's name unless said otherwise.
    scale : float
        SI value of one unit of the column [unit / column unit].
    scaled : bool
        Whether the twin file gives a scale; units in the header's brackets are then not converted.
    offset : float
        Added after scaling [unit].
    unit : str
        SI unit of the FMU variable; empty where the FMU states none.
    interpolation : {"hold", "linear"}
        Between rows, where the signal drives an FMU input.
    required : bool
        Whether a recording without this column is refused.
    compared : bool
        Whether it is compared with the twin, so that a recording with it is a log of an axis.
    driven : bool
        Whether it drives an FMU input.
    """

    name: str
    column: str
    scale: float = 1.0
    scaled: bool = False
    offset: float = 0.0
    unit: str = ""
    interpolation: Literal["hold", "linear"] = "hold"
    required: bool = False
    compared: bool = False
    driven: bool = False


@runtime_checkable
class SteppedReading(Protocol):
    """A twin that is simulated in steps."""

    step: float


@runtime_checkable
class SignalReading(Protocol):
    """Signals and parameters of a twin, for a reader of recordings."""

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        """Signals of the twin file, by name."""
        ...

    def parameter_tunable(self) -> Mapping[str, bool]:
        """Each FMU parameter, and whether it may change during a run."""
        ...


@runtime_checkable
class ResampledReading(Protocol):
    """A twin whose file has recordings put on an even clock."""

    resample: float | None
