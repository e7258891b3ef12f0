"""Methods of a user's own that break, to see what else breaks."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.tuning.history.state import TuningState
from gmfbo.tuning.method import Proposal


@dataclass(frozen=True)
class Corner:
    """Asks for the same corner for ever; from some real run on it breaks."""

    name: str = "corner"
    summary: str = "the corner of the box"
    reference: str = ""
    correction: None = None
    breaks: bool = False
    """Raises from the fourth real run on."""
    dies: bool = False
    """Ends its process there."""

    def propose(self, state: TuningState, rng: np.random.Generator) -> Proposal:
        """Propose the corner."""
        if len(state.of("IS1")) >= 3 and self.breaks:
            raise ZeroDivisionError("the corner is used up")
        if len(state.of("IS1")) >= 3 and self.dies:
            os._exit(9)
        return Proposal("IS1", np.zeros(len(state.space)))

    def recommend(self, state: TuningState) -> tuple[NDArray[np.float64], float, float]:
        """Recommend the corner."""
        return np.zeros(len(state.space)), 0.0, 0.0
