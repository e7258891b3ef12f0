"""What is scored beside the main signal, and how: band, filter, command."""

from __future__ import annotations

from dataclasses import dataclass

from gmfbo.objective.metrics import SETTLING_BAND


@dataclass(frozen=True)
class ScoringTerms:
    """Terms by which each response is scored, equal for all references of a study.

    Attributes
    ----------
    band : float
        Half width of the settling band, as a share of the step.
    filter_s : float
        [s] Time constant of the low-pass, without delay, that smooths the response.
    command : str or None
        Signal of the actuator command; None where unknown.
    velocity : str or None
        Signal of the velocity that the command moves; None where unknown.
    """

    band: float = SETTLING_BAND
    filter_s: float = 0.0
    command: str | None = None
    velocity: str | None = None


DEFAULT_TERMS = ScoringTerms()
"""Terms of a study that states none."""
