"""Uncertain parameters of a twin, from its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True)
class Uncertain:
    """An uncertain parameter of the twin.

    Attributes
    ----------
    name : str
        FMU parameter.
    nominal, low, high : float
        [FMU's unit]
    """

    name: str
    nominal: float
    low: float
    high: float

    @property
    def scale(self) -> float:
        """Typical change."""
        return max(abs(self.nominal), 0.05 * (self.high - self.low))


def uncertain_of(twin: FmuTwin) -> tuple[Uncertain, ...]:
    """Parameters of [uncertain], with ranges that contain the twin's values."""
    found = []
    for name, (low, high) in twin.file.uncertain.items():
        value = twin.nominal(name)
        found.append(Uncertain(name, value, min(low, value), max(high, value)))
    return tuple(found)
