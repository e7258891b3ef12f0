"""Outcome of a run of the master."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class LoopStage(IntEnum):
    """Call of a communication step that failed; numbers as in `master.h`."""

    NONE = 0
    SET = 1
    STEP = 2
    GET = 3
    NOT_FINITE = 4
    EVENT = 5
    ENDED = 6


@dataclass(frozen=True)
class Stop:
    """Outcome of the master, native or in Python.

    Attributes
    ----------
    stopped : bool
        Whether an FMU refused, or gave a value that is not finite; else all steps were made.
    fmu : int
        Index of the FMU.
    stage : int
        A `LoopStage`.
    step : int
        Index of the step under way; -1 while row 0 is read. Rows 0 to `step` are valid.
    fmi_status : int
        Status of the FMU's call.
    warnings : int
        Calls that answered with a warning.
    """

    stopped: bool = False
    fmu: int = 0
    stage: int = LoopStage.NONE
    step: int = 0
    fmi_status: int = 0
    warnings: int = 0
