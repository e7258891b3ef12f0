"""Points at which the augmented twin is simulated, and the simulated recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import SimulationError
from gmfbo.sources.twin.response import Response

_RUN_AWAY = 1e100  # [SI] an unstable loop gets there in a second


@dataclass(frozen=True)
class Reading:
    """A recorded position.

    Attributes
    ----------
    signal : str
        Output that holds it.
    to_si : float
        [SI / FMU's unit]
    late : float
        [rows] By which a column that holds what is added at the sensor port shows it late; 0 where
        the column is that of a plant, which does not hold it.
    """

    signal: str
    to_si: float
    late: float = 0.0

    def logged(self, response: Response, pushed: NDArray[np.float64] | float) -> Response:
        """A response whose column holds what physics adds at the sensor port at that instant.

        An FMU computes its outputs at the end of a step, of which physics set the port at the
        beginning. Its controller reads what is set for the next one.

        Parameters
        ----------
        response : Response
            As the twin was simulated.
        pushed : ndarray, shape (rows,), or float
            [FMU's unit] Added to the port beside physics, which the paths of noise account for.
        """
        added = response.ports["sensor"]
        if self.late:
            made = added - pushed
            made[-1] = made[max(made.size - 2, 0)]  # the port keeps its last step's signal there
            added = self.late * np.diff(made, prepend=made[:1])
        held, mean, more = response.held, response.mean, self.to_si * added
        return replace(
            response,
            held={**held, self.signal: held[self.signal] + more},
            mean={**mean, self.signal: mean[self.signal] + more},
        )


@dataclass(frozen=True, eq=False)
class PlayedNoise:
    """Noise that the controller of a recording saw, played into the twin.

    It overcomes small friction and bridges small dead zones: a twin without it behaves otherwise.

    Attributes
    ----------
    at_port : ndarray, shape (rows,)
        [FMU's unit] Added at a port.
    linear : tuple of ndarray, shape (n_rows of that signal,)
        [SI] Its linear answer in each signal, which is taken out again.
    port : str
        Where it is added; what the controller makes of its reading, where no port is the sensor's.
    """

    at_port: NDArray[np.float64]
    linear: tuple[NDArray[np.float64], ...]
    port: str = "sensor"


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
        Of each recording.
    own : sequence of Point
        In place of these values, in each recording; empty where they hold in all.
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    physics: Mapping[str, float] = field(default_factory=dict)
    only: Mapping[str, int] = field(default_factory=dict)
    noise: Sequence[PlayedNoise] | None = None
    own: Sequence[Point] = ()

    def parameters_in(self, record: int) -> Mapping[str, float]:
        """Values of the twin in one of the recordings."""
        return self.own[record].parameters if self.own else self.parameters

    def physics_in(self, record: int) -> dict[str, float]:
        """Physics that acts in one of the recordings."""
        physics = self.own[record].physics if self.own else self.physics
        return {
            name: value
            for name, value in physics.items()
            if self.only.get(name.partition(".")[0], record) == record
        }


@dataclass(frozen=True, eq=False)
class Simulated:
    """One recording simulated: its scored signals at their own times.

    Attributes
    ----------
    signals : tuple of ndarray, shape (n_rows of that signal,)
        [SI] Without the linear answer to played noise; NaN after a run that ended early.
    response : Response
        All simulated outputs and states.
    """

    signals: tuple[NDArray[np.float64], ...]
    response: Response

    @property
    def finite(self) -> bool:
        """Whether the run reached its end, with no signal so large that squares overflow."""
        is_done = self.response.outcome.status == "ok"
        return is_done and all(np.abs(own).max(initial=0.0) < _RUN_AWAY for own in self.signals)


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


def changes(
    runs: Sequence[Simulated], others: Sequence[Simulated]
) -> list[tuple[NDArray[np.float64], ...] | None]:
    """[SI] By how much other runs of the recordings differ; None where one ended early.

    Parameters
    ----------
    runs, others : sequence of Simulated
        By recording.
    """
    return [
        tuple(after - before for before, after in zip(one.signals, other.signals, strict=True))
        if other.finite
        else None
        for one, other in zip(runs, others, strict=True)
    ]
