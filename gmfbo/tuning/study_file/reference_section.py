"""Section of a study file about what the axis follows, and what disturbs it."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Number = Annotated[float, Field(allow_inf_nan=False)]

ReferenceKind = Literal["step", "steps", "sine", "file"]

_COMMON = {"kind", "signal", "weight", "disturbance"}
_MADE = _COMMON | {"from", "sample_time"}
_KEYS: dict[ReferenceKind, set[str]] = {
    "step": _MADE | {"step", "at", "horizon"},
    "steps": _MADE | {"times", "levels", "horizon"},
    "sine": _MADE | {"amplitude", "frequency", "cycles", "at"},
    "file": _COMMON | {"file", "column", "horizon"},
}
_NEEDED: dict[ReferenceKind, tuple[str, ...]] = {
    "step": (),
    "steps": ("times", "levels"),
    "sine": ("amplitude", "frequency", "cycles"),
    "file": ("file",),
}


class DisturbanceSection(BaseModel):
    """A step at a port of the twin while the reference is followed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    port: str = Field(min_length=1)
    step: Number
    at: NotNegative

    @model_validator(mode="after")
    def _pushes(self) -> Self:
        if self.step == 0.0:
            raise ValueError("step: expected a height other than zero")
        return self


class ReferenceSection(BaseModel):
    """Reference for the axis: a step, several, a sine, or a column of a file."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    kind: ReferenceKind | None = None  # without it: file if there is one, else step
    start: Number = Field(0.0, alias="from")
    step: Number = 1.0
    at: NotNegative = 0.1
    times: tuple[NotNegative, ...] = ()
    levels: tuple[Number, ...] = ()
    amplitude: Number = 1.0
    frequency: Positive = 1.0  # [Hz]
    cycles: Positive = 1.0
    horizon: Positive = 1.0
    sample_time: Positive = 1e-3
    signal: str = "reference"
    file: str | None = None
    column: str | None = None
    disturbance: DisturbanceSection | None = None
    weight: Positive = 1.0  # share of the cost, relative to that of other references

    @property
    def chosen(self) -> ReferenceKind:
        """Kind of the reference, also where the file does not say it."""
        return self.kind or ("step" if self.file is None else "file")

    @model_validator(mode="after")
    def _only_keys_of_its_kind(self) -> Self:
        kind = self.chosen
        stated = {"from" if key == "start" else key for key in self.model_fields_set}
        strange, lacking = stated - _KEYS[kind], set(_NEEDED[kind]) - stated
        if strange == {"file"} or (kind == "file" and strange & {"step", "at", "sample_time"}):
            raise ValueError("expected either file or step, at and sample_time, got both")
        if strange:
            raise ValueError(
                f"'{sorted(strange)[0]}' has no meaning for a reference of kind \"{kind}\"; "
                f"its keys are {', '.join(sorted(_KEYS[kind]))}"
            )
        if lacking:
            raise ValueError(f'kind = "{kind}" needs {", ".join(sorted(lacking))}')
        return self

    @model_validator(mode="after")
    def _moves(self) -> Self:
        kind = self.chosen
        if kind == "step" and self.step == 0.0 and self.disturbance is None:
            raise ValueError("step: expected a height other than zero")
        if kind == "sine" and self.amplitude == 0.0:
            raise ValueError("amplitude: expected a height other than zero")
        return self
