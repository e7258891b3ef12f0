"""Simulate motions before they are played, and shrink them until the limits hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.experiment.play_limits import PlayLimits, largest_rates
from gmfbo.diagnosis.experiment.played_input import PlayedInput, effort_for, imposed_velocity
from gmfbo.diagnosis.runs.simulated import Point
from gmfbo.errors import InputError, SimulationError
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.augmented_twin import AugmentedTwin
from gmfbo.sources.twin.response import Response
from gmfbo.sources.twin.signals import to_si
from gmfbo.sources.twin.twin import FmuTwin

Column = NDArray[np.float64]

_TRIES = 25
_NEXT = 0.995  # of the factor by which a linear axis would have to shrink
_LEAST = 0.02  # of a reference: less of it is not worth playing
_SLACK = 1e-3  # of a range, by which a controlled axis may stand off its start
_TRIED_SHARE = 0.1  # of the torque limit: effort by which a plant's motion is first simulated
_UNIT_TRIED = 1e-2  # [unit of the input] the same where there is no limit and no inertia


@dataclass(frozen=True)
class Peaks:
    """Extremes of an experiment: position, velocity, acceleration, jerk and torque.

    Attributes
    ----------
    low, high : float
        [rad or m] Of the simulated position and of a played position.
    rates : mapping of str to float
        [SI] Velocity, acceleration and jerk of the played motion; of the simulated one where the
        plant is driven without a controller.
    torque : float or None
        [torque_unit] Largest amount that the drive is asked for; None where no state tells it.
    torque_unit : str
        Of the state command or current, or of the input.
    """

    low: float
    high: float
    rates: Mapping[str, float]
    torque: float | None
    torque_unit: str

    def joined(self, other: Peaks) -> Peaks:
        """Extremes of two experiments together."""
        torque = self.torque
        if torque is not None and other.torque is not None:
            torque = max(torque, other.torque)
        rates = {name: max(value, other.rates[name]) for name, value in self.rates.items()}
        return Peaks(
            min(self.low, other.low), max(self.high, other.high), rates, torque, self.torque_unit
        )

    def excess(self, limits: PlayLimits, start: float) -> float:
        """Largest used share of any limit; above one the limit is exceeded."""
        slack = _SLACK * (limits.high - limits.low)
        shares = [
            (self.high - start) / max(limits.high - start, slack),
            (start - self.low) / max(start - limits.low, slack),
            *(value / limits.rate(name) for name, value in self.rates.items()),
        ]
        if self.torque is not None:
            shares.append(self.torque / limits.torque)
        return max(shares)


class SafePlayer:
    """Simulates a motion at the twin's values and under each explanation.

    Parameters
    ----------
    twin : FmuTwin
        The twin.
    played : PlayedInput
        Input that is played.
    limits : PlayLimits
        Of the axis.
    substeps : int
        Steps of physics in a communication step.
    points : sequence of Point
        Values under which the limits have to hold.
    """

    def __init__(
        self,
        twin: FmuTwin,
        played: PlayedInput,
        limits: PlayLimits,
        substeps: int,
        points: Sequence[Point] = (Point(),),
    ) -> None:
        self.twin, self.played, self.limits, self.points = twin, played, limits, tuple(points)
        self.spacing = twin.step
        self._simulator = AugmentedTwin(twin, substeps=substeps)
        self._torque_state = next(
            (s for s in ("command", "current") if s in twin.file.states), None
        )
        if np.isfinite(limits.torque) and self._torque_state is None and played.kind != "effort":
            raise InputError(
                f"{twin.name}: a torque limit was given, but the twin names no state 'command' or "
                "'current' that it could be held against; name one under [states], or leave torque "
                "out"
            )

    def __enter__(self) -> SafePlayer:
        return self

    def __exit__(self, *error: object) -> None:
        self._simulator.close()

    @property
    def start(self) -> float:
        """[rad or m] Position of the axis before anything is played."""
        if self.played.kind == "position":
            return self.played.start
        still = self._run(np.zeros(4), Point())
        return float(self._position(still, np.zeros(4))[0])

    def reference(self, column: Column, name: str = "") -> Recording:
        """Recording that plays a column.

        Parameters
        ----------
        column : ndarray, shape (rows,)
            [unit of the input]
        name : str
            Of the file.
        """
        time = np.arange(column.size, dtype=np.float64) * self.spacing
        return Recording(
            time=time,
            signals={self.played.name: column},
            units={self.played.name: self.played.unit} if self.played.unit else {},
            name=name,
        )

    def shrunk(self, motion: Column) -> tuple[Column, Column, Peaks, float]:
        """Shrink a motion about its start until every point stays within the limits.

        Parameters
        ----------
        motion : ndarray, shape (rows,)
            [rad or m]

        Returns
        -------
        tuple
            Motion, column to play, extremes, and the factor by which it was shrunk.

        Raises
        ------
        InputError
            The limits leave next to nothing of the motion.
        SimulationError
            The twin cannot follow it.
        """
        share, start = 1.0, float(motion[0])
        for _ in range(_TRIES):
            moved = start + share * (motion - start)
            column = self._column(moved)
            peaks = self.peaks(moved, column)
            excess = peaks.excess(self.limits, start)
            if excess <= 1.0:
                return moved, column, peaks, share
            share *= min(_NEXT / excess, _NEXT)
            if share < _LEAST:
                break
        raise InputError(self._too_much(peaks, share))

    def peaks(self, motion: Column, column: Column) -> Peaks:
        """Extremes of the motion over all points.

        Parameters
        ----------
        motion : ndarray, shape (rows,)
            [rad or m] Wanted motion.
        column : ndarray, shape (rows,)
            [unit of the input] Column that is played.
        """
        found: Peaks | None = None
        for point in self.points:
            one = self._peaks(self._run(column, point), motion, column)
            found = one if found is None else found.joined(one)
        assert found is not None, "there is at least the twin as it is"
        return found

    # ---- one run -----------------------------------------------------------------------------

    def _run(self, column: Column, point: Point) -> Response:
        plan = self._simulator.plan(self.reference(column), point.parameters)
        response = self._simulator.run(plan, point.parameters, point.physics)
        if response.outcome.status != "ok":
            raise SimulationError(
                f"{self.twin.name}: the twin cannot follow what would be played: "
                f"{response.outcome.message}"
            )
        return response

    def _column(self, motion: Column) -> Column:
        if self.played.kind == "position":
            return motion
        if self.played.kind == "velocity":
            return imposed_velocity(motion, self.spacing)
        return effort_for(motion, self.spacing, self._moved, self._tried())

    def _moved(self, effort: Column) -> Column:
        position = self._position(self._run(effort, Point()), effort)
        return np.asarray(position - position[0], dtype=np.float64)

    def _tried(self) -> float:
        if np.isfinite(self.limits.torque):
            return _TRIED_SHARE * self.limits.torque
        role = self.twin.file.roles.get("inertia")
        if role is not None:
            return _TRIED_SHARE * self.limits.acceleration * self.twin.nominal(role)
        return _UNIT_TRIED

    def _peaks(self, response: Response, motion: Column, column: Column) -> Peaks:
        position = self._position(response, motion)
        rates = largest_rates(motion, self.spacing)
        low, high = float(position.min()), float(position.max())
        if self.played.kind == "position":
            low, high = min(low, float(motion.min())), max(high, float(motion.max()))
        elif self.played.kind == "effort":
            rates = largest_rates(position, self.spacing)
            rates.pop("jerk")  # of a plant that is pushed by a held effort it is that of the hold
        torque, unit = None, ""
        if self._torque_state is not None:
            torque, unit = self._torque(response, self._torque_state)
        elif self.played.kind == "effort":
            torque, unit = float(np.abs(column).max()), self.played.unit
        return Peaks(low, high, rates, torque, unit)

    def _torque(self, response: Response, state: str) -> tuple[float, str]:
        variable = self.twin.binding.variables[self.twin.file.states[state]].variable
        return float(np.abs(to_si(variable, response.states[state])).max()), variable.si_unit

    def _position(self, response: Response, otherwise: Column) -> Column:
        """Simulated position [SI]; the wanted motion where no state holds it."""
        name = self.twin.file.states.get("position")
        if name is None:
            return otherwise
        variable = self.twin.binding.variables[name].variable
        position: Column = to_si(variable, response.states["position"])
        return position

    def _too_much(self, peaks: Peaks, share: float) -> str:
        limits = self.limits
        told = (
            f"{100.0 * share:.2g} % of the reference still takes the axis from {peaks.low:.3g} to "
            f"{peaks.high:.3g} (allowed {limits.low:g} to {limits.high:g})"
        )
        if peaks.torque is not None and np.isfinite(limits.torque):
            told += (
                f" and asks for {peaks.torque:.3g} {peaks.torque_unit} (allowed {limits.torque:g})"
            )
        return f"{self.twin.name}: no reference within these limits: {told}; widen a limit"
