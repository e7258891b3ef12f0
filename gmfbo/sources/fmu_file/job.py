"""Job: one run of wired FMUs in terms of value references."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal, NamedTuple

Status = Literal["ok", "diverged", "failed", "crashed", "timeout"]

STOP_TIME_LINE = "stop_time = true"
"""Line of a twin file that announces each run's end."""


class ValueType(IntEnum):
    """Type of a variable at the FMI interface; numbers as in `master.h`.

    FMI 2.0 has the first three; in FMI 3.0 `REAL` is Float64 and `INTEGER` Int32. Enumerations are
    `INTEGER` in FMI 2.0, `INT64` in FMI 3.0.
    """

    REAL = 0
    INTEGER = 1
    BOOLEAN = 2
    FLOAT32 = 3
    INT8 = 4
    UINT8 = 5
    INT16 = 6
    UINT16 = 7
    UINT32 = 8
    INT64 = 9
    UINT64 = 10

    @property
    def is_real(self) -> bool:
        """Whether the type is a floating-point number."""
        return self in (ValueType.REAL, ValueType.FLOAT32)


_REFERENCE_BITS = 32  # of a value reference; what lies above tells an element of an array
LARGEST_SIZE = 1000
"""Most elements of an array that are variables of their own; nobody maps more by name."""


class ArrayElement(NamedTuple):
    """An element of an array of FMI 3.0: value reference, place from 0, and size of the array."""

    reference: int
    place: int
    size: int

    @property
    def packed(self) -> int:
        """The element as one whole number, in place of a value reference."""
        above = self.place * (LARGEST_SIZE + 1) + self.size
        return self.reference + (above << _REFERENCE_BITS)

    @classmethod
    def of(cls, reference: int) -> ArrayElement | None:
        """Element of a packed number; None for a value reference, which is a scalar's."""
        above = reference >> _REFERENCE_BITS
        if not above:
            return None
        place, size = divmod(above, LARGEST_SIZE + 1)
        return cls(reference & (2**_REFERENCE_BITS - 1), place, size)


class Port(NamedTuple):
    """A variable of one FMU, and the array column that it is read from or written to."""

    fmu: int
    reference: int
    type: int
    column: int


class Wire(NamedTuple):
    """Input = scale * output, before every step of the FMU that owns the input."""

    to_fmu: int
    to_reference: int
    to_type: int
    from_fmu: int
    from_reference: int
    from_type: int
    scale: float = 1.0


class Setting(NamedTuple):
    """A parameter that is set before initialisation."""

    fmu: int
    reference: int
    type: int
    value: float


class TextSetting(NamedTuple):
    """A parameter of type String that is set before initialisation."""

    fmu: int
    reference: int
    value: str


@dataclass(frozen=True)
class Job:
    """A whole run, without its arrays.

    Attributes
    ----------
    steps : int
        Communication steps.
    start : float
        [s] FMU time of row 0.
    step : float
        [s] Communication step; row k is at start + k * step.
    settings : tuple of Setting
        Parameters before initialisation.
    inputs, schedules, outputs : tuple of Port
        Columns of u (steps, n_u), s (steps, n_s) and y (steps + 1, n_y).
    wires : tuple of Wire
        From outputs to inputs.
    told_start : float or None
        [s] Time of row 0 by the recording's clock, for messages; `start` unless given.
    texts : tuple of TextSetting
        Parameters of type String, before initialisation.
    stop : float or None
        [s] Stop time that is announced to the FMUs; None announces none.
    """

    steps: int
    start: float
    step: float
    settings: tuple[Setting, ...] = ()
    inputs: tuple[Port, ...] = ()
    schedules: tuple[Port, ...] = ()
    wires: tuple[Wire, ...] = ()
    outputs: tuple[Port, ...] = ()
    told_start: float | None = None
    texts: tuple[TextSetting, ...] = ()
    stop: float | None = None

    @property
    def has_arrays(self) -> bool:
        """Whether an element of an array is set or read at each step."""
        ports = (*self.inputs, *self.schedules, *self.outputs)
        references = [port.reference for port in ports]
        references += [r for wire in self.wires for r in (wire.to_reference, wire.from_reference)]
        return any(reference >> _REFERENCE_BITS for reference in references)

    @property
    def duration(self) -> float:
        """[s] Simulated time."""
        return self.steps * self.step

    def told_time(self, row: int) -> float:
        """[s] Time of a row by the recording's clock.

        Parameters
        ----------
        row : int
            Its place, from 0.
        """
        return (self.start if self.told_start is None else self.told_start) + row * self.step

    @property
    def shapes(self) -> tuple[tuple[int, int], tuple[int, int], tuple[int, int]]:
        """Shapes of u, s and y."""
        return (
            (self.steps, len(self.inputs)),
            (self.steps, len(self.schedules)),
            (self.steps + 1, len(self.outputs)),
        )

    @classmethod
    def from_json(cls, raw: Mapping[str, Any]) -> Job:
        """Read back what `json.dumps(vars(job))` wrote."""
        return cls(
            steps=raw["steps"],
            start=raw["start"],
            step=raw["step"],
            settings=tuple(Setting(*entry) for entry in raw["settings"]),
            inputs=tuple(Port(*entry) for entry in raw["inputs"]),
            schedules=tuple(Port(*entry) for entry in raw["schedules"]),
            wires=tuple(Wire(*entry) for entry in raw["wires"]),
            outputs=tuple(Port(*entry) for entry in raw["outputs"]),
            told_start=raw["told_start"],
            texts=tuple(TextSetting(*entry) for entry in raw["texts"]),
            stop=raw["stop"],
        )


class Stage(IntEnum):
    """Stage of a run: the request that an FMU is working on."""

    IDLE = 0
    LOAD = 1
    INSTANTIATE = 2
    INITIALISE = 3
    STEP = 4
    FREE = 5
    ANSWER = 6

    @property
    def words(self) -> str:
        """Words for messages: "crashed while ..."."""
        return {
            Stage.IDLE: "waiting",
            Stage.LOAD: "being loaded",
            Stage.INSTANTIATE: "being instantiated",
            Stage.INITIALISE: "initialising",
            Stage.STEP: "stepping",
            Stage.FREE: "being freed",
            Stage.ANSWER: "having run",
        }[self]


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Attributes
    ----------
    status : {"ok", "diverged", "failed", "crashed", "timeout"}
        Same words as the status of a trajectory.
    rows : int
        Leading rows of y that are valid.
    message : str
        Cause of the end, in one line; empty when `status` is `ok`.
    warnings : int
        FMI calls that answered with a warning.
    stage : Stage
        Request to the FMU during which it failed.
    """

    status: Status
    rows: int
    message: str = ""
    warnings: int = 0
    stage: Stage = Stage.IDLE
