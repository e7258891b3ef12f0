"""Parameters of a twin that its file calls uncertain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gmfbo.sources.twin.twin import FmuTwin


@dataclass(frozen=True)
class Uncertain:
    """A parameter of the twin that is known only roughly.

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
    """Parameters of [uncertain], about their values in the twin; a range holds its value.

    Parameters
    ----------
    twin : FmuTwin
        The twin.
    """
    found = []
    for name, (low, high) in twin.file.uncertain.items():
        value = twin.nominal(name)
        found.append(Uncertain(name, value, min(low, value), max(high, value)))
    return tuple(found)
