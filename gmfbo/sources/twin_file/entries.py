"""Entries of a twin file: numbers, ranges of gains, signals, controllers."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictBool, model_validator

CONTROLLER_KINDS = ("pd_filtered", "cascade_p_pi", "pid")

# Strict: a number in quotes is a mistake, not a number.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)]
Text = Annotated[str, Field(min_length=1)]


def _is_stop_time(value: object) -> object:
    # Checked here, since a union of a Boolean and a number would report both failures.
    if isinstance(value, bool) or (isinstance(value, int | float) and math.isfinite(value)):
        return value
    raise ValueError(f"expected true, false or a number of seconds, got {value!r:.60}")


StopTime = Annotated[StrictBool | float, BeforeValidator(_is_stop_time)]


def _as_number(value: object) -> object:
    # A Boolean parameter is set by true and false, which TOML distinguishes from numbers.
    return float(value) if isinstance(value, bool) else value


def _as_pair(value: object) -> object:
    if isinstance(value, list) and len(value) == 2:
        low, high = value
        if all(isinstance(v, int | float) and math.isfinite(v) for v in value) and low < high:
            return value
    raise ValueError(f"expected [low, high] with low < high, got {value}")


ParameterValue = Annotated[Number, BeforeValidator(_as_number)]
Pair = Annotated[tuple[float, float], BeforeValidator(_as_pair)]


class Table(BaseModel):
    """A table of the file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class FixedNames(Table):
    """Parameters that are known for certain.

    Attributes
    ----------
    names : list of str
        FMU parameters, or shell patterns of their names.
    """

    names: list[Text] = Field(default_factory=list)


class RecordingTable(Table):
    """How recordings are followed.

    Attributes
    ----------
    clock : {"own", "fmu"}
        Whether an FMU's time counts from its own start time, or is the recorded time.
    resample : float or None
        [s] Step of an even clock that the rows of recordings are put on.
    """

    clock: Literal["own", "fmu"] = "own"
    resample: Positive | None = None


class LimitsTable(Table):
    """What a run may cost.

    Attributes
    ----------
    steps : int
        Steps of the FMUs in a run along a recording, substeps counted.
    """

    steps: Annotated[int, Field(strict=True, gt=0)] = 20_000_000


class TableEntry(Table):
    """A lookup table inside the FMU whose nodes are uncertain.

    Attributes
    ----------
    nodes : str
        FMU variables `NODES[i]` or `NODES[i,j]`, from 1, that hold the table in force.
    deltas : str or None
        FMU parameters `DELTAS[i,j]` added to the table; None where the nodes are parameters.
    rising : {"rows", "columns"} or None
        Index along which no value is smaller than the one before it: `rows` is the first.
    """

    nodes: Text
    deltas: Text | None = None
    rising: Literal["rows", "columns"] | None = None


class GainRange(Table):
    """Range of one gain; a fixed gain has low = high.

    Attributes
    ----------
    low, high : float
        Bounds [unit of the FMU parameter].
    scale : {"linear", "log"}
        Whether the range is searched by its values or by their logarithm.
    integer : bool
        Whether only whole numbers are allowed.
    """

    low: Number
    high: Number
    scale: Literal["linear", "log"] = "linear"
    integer: bool = False

    @model_validator(mode="before")
    @classmethod
    def _from_short_form(cls, value: object) -> object:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return {"low": value, "high": value}
        if isinstance(value, list):
            if len(value) != 2:
                raise ValueError(f"expected [low, high], got {value}")
            return {"low": value[0], "high": value[1]}
        return value

    @model_validator(mode="after")
    def _low_below_high(self) -> Self:
        if self.low > self.high:
            raise ValueError(f"expected low <= high, got [{self.low:g}, {self.high:g}]")
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError(f"a log scale needs a positive lower bound, got {self.low:g}")
        return self

    @property
    def fixed(self) -> bool:
        """Whether the range is a single value."""
        return self.low == self.high


class SignalEntry(Table):
    """One recorded signal and its FMU variable: value in SI = scale * column + offset.

    Attributes
    ----------
    variable : str
        FMU variable.
    column : str or None
        Recorded column; the signal's name unless given.
    scale : float, str or None
        [SI unit / column unit], or the FMU parameter that holds it.
    offset : float or "fit"
        [SI unit] `fit` counts as 0 until the diagnosis refits it.
    uncertain_scale : float or None
        Share of the scale that the diagnosis may refit.
    shift_range : tuple of float or None
        [s] Range of the time shift that the diagnosis may fit.
    wrapped : bool or None
        Whether the column is an angle that the logger wraps into one turn; recognised unless given.
    """

    variable: Text
    column: Text | None = None
    scale: Number | Text | None = None
    offset: Number | Literal["fit"] = 0.0
    uncertain_scale: Positive | None = None
    shift_range: Pair | None = None
    wrapped: bool | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, value: object) -> object:
        return {"variable": value} if isinstance(value, str) else value


class InputEntry(SignalEntry):
    """A recorded signal that drives an FMU input.

    Attributes
    ----------
    interpolation : {"hold", "linear"}
        Between recorded rows.
    """

    interpolation: Literal["hold", "linear"] = "hold"


class OutputEntry(SignalEntry):
    """A recorded signal that an FMU output is compared with.

    Attributes
    ----------
    interpolation : {"hold", "linear"}
        Between recorded rows.
    logged : {"held", "new", "unknown"}
        Whether the logger stores the command still held at t_k or the one just computed.
    """

    interpolation: Literal["hold", "linear"] = "hold"
    logged: Literal["held", "new", "unknown"] = "unknown"


class ControllerEntry(BaseModel):
    """One of the project's own controllers; further keys are its parameters.

    Attributes
    ----------
    kind : {"pd_filtered", "cascade_p_pi", "pid"}
        FMU of `models/`.
    """

    model_config = ConfigDict(extra="allow", frozen=True)

    kind: Literal["pd_filtered", "cascade_p_pi", "pid"]

    @property
    def settings(self) -> dict[str, float]:
        """Parameters that the file gives, by the controller's own names."""
        return dict(self.__pydantic_extra__ or {})

    @model_validator(mode="after")
    def _settings_are_numbers(self) -> Self:
        for name, value in (self.__pydantic_extra__ or {}).items():
            if not isinstance(value, int | float) or not math.isfinite(value):
                raise ValueError(f"{name}: expected a number, got {value!r}")
        return self
