"""What is simulated at a point of the augmented twin, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import SimulationError
from gmfbo.sources.twin.augmented_twin import Response


@dataclass(frozen=True)
class Reading:
    """A recorded position.

    Attributes
    ----------
    signal : str
        Output that it is.
    to_si : float
        [SI / FMU's unit]
    """

    signal: str
    to_si: float


class PlayedNoise(Protocol):
    """Noise that the controller saw in a recording."""

    @property
    def signal(self) -> str:
        """Output that is the reading."""

    @property
    def at_port(self) -> NDArray[np.float64]:
        """[FMU's unit] What is added at the sensor port, shape (rows,)."""

    def logged(self, response: Response) -> Response:
        """Let the simulated reading hold it."""

    def slow_part(self, change: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
        """What of a signal's change under the noise is slower than the noise."""


@dataclass(frozen=True)
class Point:
    """Values at which the augmented twin is run.

    Attributes
    ----------
    parameters : mapping of str to float
        [FMU's unit] Of the twin.
    physics : mapping of str to float
        Of physics.fmu.
    only : mapping of str to int
        Effects that act in one recording only, and which that is.
    noise : sequence of PlayedNoise or None
        Read off each recording; what it changes of the slower part is added to what the quiet
        twin shows.
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    physics: Mapping[str, float] = field(default_factory=dict)
    only: Mapping[str, int] = field(default_factory=dict)
    noise: Sequence[PlayedNoise | None] | None = None

    def physics_in(self, record: int) -> dict[str, float]:
        """Physics that acts in one of the recordings."""
        return {
            name: value
            for name, value in self.physics.items()
            if self.only.get(name.partition(".")[0], record) == record
        }


@dataclass(frozen=True, eq=False)
class Simulated:
    """One recording simulated: its scored signals at their own times.

    Attributes
    ----------
    quiet : tuple of ndarray, shape (n_rows of that signal,)
        [SI] Without noise; NaN after a run that ended early.
    response : Response
        All that was simulated, without noise.
    under_noise : tuple of ndarray, optional
        [SI] The signals with what noise changes of their slower part, where it is played.
    """

    quiet: tuple[NDArray[np.float64], ...]
    response: Response
    under_noise: tuple[NDArray[np.float64], ...] | None = None

    @property
    def signals(self) -> tuple[NDArray[np.float64], ...]:
        """[SI] What is compared with the recording."""
        return self.quiet if self.under_noise is None else self.under_noise

    @property
    def finite(self) -> bool:
        """The run went to its end."""
        return self.response.outcome.status == "ok"


@dataclass(frozen=True, eq=False)
class Tracking:
    """A loop that holds an open-loop twin on its recordings by force.

    Attributes
    ----------
    settings : mapping of str to float
        Of physics.fmu.
    measured : tuple of ndarray, shape (rows,)
        [FMU's unit] Recorded position of each recording on the communication grid.
    """

    settings: Mapping[str, float]
    measured: tuple[NDArray[np.float64], ...]


def require_run(simulated: Sequence[Simulated], what: str) -> None:
    """Stop where even the starting point cannot be simulated.

    Raises
    ------
    SimulationError
        With the words of the first run that failed.
    """
    for run in simulated:
        if not run.finite:
            raise SimulationError(f"{what}: {run.response.outcome.message}")
