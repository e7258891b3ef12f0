"""Section of a study file about safety: the envelope, and known-safe gains."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from gmfbo.errors import InputError
from gmfbo.objective.condition import Condition
from gmfbo.objective.envelope import Envelope

Number = Annotated[float, Field(allow_inf_nan=False)]


class SafetySection(BaseModel):
    """Ranges of recorded signals, a condition on them, and known-safe gains.

    In the file each signal is a key of its own, beside `expression` and `start`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    ranges: dict[str, tuple[Number, Number]] = {}
    expression: str | None = None
    start: tuple[tuple[Number, ...], ...] = ()  # one value for each tuned gain, in order

    @model_validator(mode="before")
    @classmethod
    def _signals_are_keys(cls, value: Any) -> Any:
        if not isinstance(value, dict) or "ranges" in value:
            return value
        named = {key: value[key] for key in value if key in ("expression", "start")}
        ranges = {key: value[key] for key in value if key not in named}
        for name, pair in ranges.items():
            if not (isinstance(pair, list) and len(pair) == 2):
                raise ValueError(f"{name}: expected [low, high], got {pair!r}")
        return {**named, "ranges": ranges}

    @model_validator(mode="after")
    def _usable(self) -> Self:
        for name, (low, high) in self.ranges.items():
            if not low < high:
                raise ValueError(f"{name}: expected low < high, got [{low:g}, {high:g}]")
        if self.expression is not None:
            try:
                Condition.parse(self.expression)
            except InputError as error:
                raise ValueError(str(error)) from None
        return self

    @property
    def envelope(self) -> Envelope:
        """Safety envelope of recorded signals; empty where the section is."""
        condition = None if self.expression is None else Condition.parse(self.expression)
        return Envelope(dict(self.ranges), condition)
