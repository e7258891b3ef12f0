"""How a recorded column becomes a signal in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable


@dataclass(frozen=True)
class SignalSpec:
    """One signal of a twin file, told in the recording's words: value = scale * column + offset.

    Attributes
    ----------
    name : str
        The user's name for the signal.
    column : str
        Name of the recorded column; the signal's name unless said otherwise.
    scale : float
        SI value of one unit of the column [unit / column unit].
    scaled : bool
        The twin file gave a scale, so units in the header's brackets are not converted.
    offset : float
        Added after scaling [unit].
    unit : str
        SI unit of the FMU variable; empty where the FMU states none.
    interpolation : {"hold", "linear"}
        Between rows, where the signal drives an FMU input.
    required : bool
        A recording without this column is refused.
    """

    name: str
    column: str
    scale: float = 1.0
    scaled: bool = False
    offset: float = 0.0
    unit: str = ""
    interpolation: Literal["hold", "linear"] = "hold"
    required: bool = False


@runtime_checkable
class SignalReading(Protocol):
    """What a reader must know of a twin."""

    def signal_specs(self) -> Mapping[str, SignalSpec]:
        """Return the signals that the twin file names, by name."""
        ...

    def parameter_tunable(self) -> Mapping[str, bool]:
        """Return each FMU parameter, and whether it may change during a run."""
        ...
