"""The twin file: an FMU told in the recording's words."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from gmfbo.errors import TwinFileError, did_you_mean
from gmfbo.sources.validation import describe_problems

KNOWN_STATES = (
    "position",
    "velocity",
    "command",
    "current",
    "voltage",
    "load_torque",
    "load_position",
    "temperature",
)
CONTROLLER_KINDS = ("pd_filtered", "cascade_p_pi", "pid")

# Strict: a number in quotes is a mistake, not a number.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)]
Text = Annotated[str, Field(min_length=1)]


def _as_number(value: object) -> object:
    # A Boolean parameter is set by true and false; TOML keeps them apart from numbers.
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
    """A table of the file; keys that it does not know are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class GainRange(Table):
    """Range of one gain [unit of the FMU parameter]; a fixed gain has low = high."""

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
        """The range holds one value only."""
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
        [s] Within which the diagnosis may shift the signal in time.
    """

    variable: Text
    column: Text | None = None
    scale: Number | Text | None = None
    offset: Number | Literal["fit"] = 0.0
    uncertain_scale: Positive | None = None
    shift_range: Pair | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, value: object) -> object:
        return {"variable": value} if isinstance(value, str) else value


class InputEntry(SignalEntry):
    """A recorded signal that drives an FMU input."""

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
    """One of the project's own controllers; further keys are its parameters."""

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


class TwinFile(Table):
    """A validated twin file; paths in it are relative to its folder.

    Attributes
    ----------
    name : str
        For people.
    fmu : str or None
        Path of the FMU; None where `fmus` is given.
    fmus : dict of str to str or ControllerEntry
        FMUs by the prefix of their variables, in order of computation.
    wires : dict of str to str
        FMU input = FMU output.
    step : float
        [s] Communication step.
    warmup : float or None
        [s] Simulated, but not scored.
    inputs, outputs : dict
        Recorded signal = FMU variable.
    parameters : dict of str to float
        Set before initialisation.
    gains : dict of str to GainRange
        What tuning may move.
    uncertain : dict of str to tuple of float
        Known only roughly: [low, high].
    ports, states, roles : dict of str to str
        FMU inputs where physics may act, outputs it may depend on, parameters with a meaning.
    initial : dict of str to str or float
        FMU parameter = recorded signal, number, or "fit".
    """

    name: Text
    fmu: Text | None = None
    fmus: dict[str, Text | ControllerEntry] = {}
    wires: dict[str, Text] = {}
    step: Positive
    warmup: NotNegative | None = None
    inputs: dict[str, InputEntry] = {}
    outputs: dict[str, OutputEntry]
    parameters: dict[str, ParameterValue] = {}
    gains: dict[str, GainRange] = {}
    uncertain: dict[str, Pair] = {}
    ports: dict[str, Text] = {}
    states: dict[str, Text] = {}
    roles: dict[str, Text] = {}
    initial: dict[str, Number | Text] = {}

    @field_validator("fmus", mode="before")
    @classmethod
    def _known_controllers(cls, value: object) -> object:
        # Said here, since a union of a text and a table would report both of its failures.
        for name, entry in value.items() if isinstance(value, dict) else ():
            if isinstance(entry, dict) and entry.get("kind") not in CONTROLLER_KINDS:
                kind = str(entry.get("kind", ""))
                raise ValueError(
                    f"{name}: no controller kind '{kind}'" + did_you_mean(kind, CONTROLLER_KINDS)
                )
            if not isinstance(entry, dict | str):
                raise ValueError(f"{name}: expected a path or a table with kind, got {entry!r}")
            if not name or "." in name:
                raise ValueError(f"'{name}': expected a prefix without a dot")
        return value

    @field_validator("states")
    @classmethod
    def _known_states(cls, value: dict[str, str]) -> dict[str, str]:
        for name in value:
            if name not in KNOWN_STATES:
                raise ValueError(f"no state '{name}'" + did_you_mean(name, KNOWN_STATES))
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.fmu is None) == (not self.fmus):
            raise ValueError("expected either fmu = FILE or a table [fmus]")
        if self.wires and not self.fmus:
            raise ValueError("[wires] joins the FMUs of [fmus]; with fmu = FILE there is none")
        if not self.outputs:
            raise ValueError("[outputs]: expected at least one signal to compare")
        for signal in self.inputs:
            if signal in self.outputs:
                raise ValueError(f"signal '{signal}' is in [inputs] and in [outputs]; rename one")
        return self

    @classmethod
    def parse(cls, text: str, label: str) -> TwinFile:
        """Read and validate the text of a twin file.

        Parameters
        ----------
        text : str
            TOML.
        label : str
            Name of the file, for messages.

        Raises
        ------
        TwinFileError
            One line with each of the first few problems.
        """
        try:
            raw: dict[str, Any] = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise TwinFileError(f"{label}: not valid TOML: {error}") from None
        try:
            return cls.model_validate(raw)
        except ValidationError as error:
            raise TwinFileError(f"{label}: {describe_problems(error, cls)}") from None

    @classmethod
    def read(cls, path: str | Path) -> TwinFile:
        """Read and validate a twin file.

        Parameters
        ----------
        path : str or Path
            The `.toml` file.

        Raises
        ------
        TwinFileError
            It is missing, not UTF-8, not TOML, or says what a twin file cannot say.
        """
        path = Path(path)
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise TwinFileError(
                f"{path.name}: expected UTF-8 text; is it an FMU? give the twin file (.toml)"
            ) from None
        except OSError as error:
            raise TwinFileError(
                f"no twin file at '{path}' ({error.strerror or error}); check the path"
            ) from None
        return cls.parse(text, path.name)
