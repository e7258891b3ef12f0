"""Points at which the augmented twin is simulated, and the simulated recordings."""

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
        Output that holds it.
    to_si : float
        [SI / FMU's unit]
    """

    signal: str
    to_si: float


class PlayedNoise(Protocol):
    """Noise that the controller saw in a recording."""

    @property
    def signal(self) -> str:
        """Output that holds the reading."""

    @property
    def at_port(self) -> NDArray[np.float64]:
        """[FMU's unit] Noise added at the sensor port, shape (rows,)."""

    def logged(self, response: Response) -> Response:
        """Simulated readings with the noise in them."""

    def slow_part(self, change: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
        """Part of a signal's change under the noise that is slower than the noise."""


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
        Recording of each effect that acts in only one.
    noise : sequence of PlayedNoise or None
        Replayed noise of each recording; the slow change that it causes is added to the signals
        of the quiet twin.
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
        All simulated outputs and states, without noise.
    under_noise : tuple of ndarray, optional
        [SI] Signals with the slow change caused by noise, where noise is played.
    """

    quiet: tuple[NDArray[np.float64], ...]
    response: Response
    under_noise: tuple[NDArray[np.float64], ...] | None = None

    @property
    def signals(self) -> tuple[NDArray[np.float64], ...]:
        """[SI] Signals that are compared with the recording."""
        return self.quiet if self.under_noise is None else self.under_noise

    @property
    def finite(self) -> bool:
        """Whether the run reached its end."""
        return self.response.outcome.status == "ok"


@dataclass(frozen=True, eq=False)
class Tracking:
    """A feedback loop that holds an open-loop twin on its recordings by force.

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
    """Raise where a recording could not be simulated to its end.

    Raises
    ------
    SimulationError
        With the message of the first run that failed.
    """
    for run in simulated:
        if not run.finite:
            raise SimulationError(f"{what}: {run.response.outcome.message}")
