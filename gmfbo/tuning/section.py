"""What every part of a study file has in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """Part of a study file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)
