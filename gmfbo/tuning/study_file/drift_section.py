"""Section of a study file about changes of the plant."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field, field_validator


class DriftSection(BaseModel):
    """Detection of changes of the plant, and repeated runs that show them sooner."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    watch: bool = True
    repeat_every: int = Field(0, ge=0)  # real runs; 0 repeats none

    @field_validator("repeat_every")
    @classmethod
    def _leaves_room(cls, value: int) -> int:
        if value == 1:
            raise ValueError("expected 0 or at least 2: if every run is a repeat, none is new")
        return value
