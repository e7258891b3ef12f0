"""How a pass of the master ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class LoopStage(IntEnum):
    """Which call of a communication step did not end well; numbers as in `master.h`."""

    NONE = 0
    SET = 1
    STEP = 2
    GET = 3
    NOT_FINITE = 4
    EVENT = 5
    ENDED = 6


@dataclass(frozen=True)
class Stop:
    """The result of the master, native or in Python.

    Attributes
    ----------
    stopped : bool
        An FMU refused, or gave a value that is not finite; else all steps were made.
    fmu : int
        Which.
    stage : int
        A `LoopStage`.
    step : int
        Index of the step under way; -1 while row 0 is read. Rows 0 to `step` are valid.
    fmi_status : int
        What the FMU answered.
    warnings : int
        Calls that answered with a warning.
    """

    stopped: bool = False
    fmu: int = 0
    stage: int = LoopStage.NONE
    step: int = 0
    fmi_status: int = 0
    warnings: int = 0
