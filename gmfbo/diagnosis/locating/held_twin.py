"""Make a twin follow its recordings: its controller by the sensor port, its plant by force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.case.tracking import HOLDING_RAD_S, tracking_loop
from gmfbo.diagnosis.fitting.fit import Fitted
from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.sources.twin.response import Response

DISTURBANCE = 0.05
"""Hidden disturbance of a null simulation, as a share of the torque's range."""

_DISTURBANCE_HZ = 7.0

Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeldTwin:
    """Runs of a fitted twin that is made to follow measurements.

    Attributes
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        The model that is held.
    position : str
        Output that was recorded as the position.
    settings : mapping of str to float
        Of the loops of physics.fmu; empty where no port takes any.
    """

    case: Case
    base: Fitted
    position: str
    settings: Mapping[str, float]

    @property
    def feeds_controller(self) -> bool:
        """Whether the controller reads the measurement."""
        return "tracking.sensor" in self.settings

    @property
    def holds_plant(self) -> bool:
        """Whether a force makes the plant follow the measurement."""
        return "tracking.kp" in self.settings

    @property
    def busiest(self) -> int:
        """Recording with the longest path."""
        runs = self.base.simulated
        return int(
            np.argmax([np.abs(np.diff(run.response.held[self.position])).sum() for run in runs])
        )

    def recorded(self, k: int) -> Column:
        """Recorded position on the communication grid [FMU's unit], shape (rows,)."""
        record = self.case.simulations.records[k]
        return self._on_grid(k, record.plan.recording.signal(self.position))

    def logged(self, k: int, simulated: Column) -> Column:
        """Return a simulated position [SI] as the logger would have sampled it [FMU's unit]."""
        record = self.case.simulations.records[k]
        recording = record.plan.recording
        known = np.isfinite(recording.signal(self.position))
        sampled = np.interp(recording.time, record.plan.grid, simulated)
        return self._on_grid(k, np.where(known, sampled, np.nan))

    def _on_grid(self, k: int, column: Column) -> Column:
        plan = self.case.simulations.records[k].plan
        known = np.isfinite(column)
        values = np.interp(plan.grid, plan.recording.time[known], column[known])
        return np.asarray(values / self.case.rig.position_to_si, dtype=np.float64)

    def run(self, measured: Mapping[int, Column]) -> list[Response] | None:
        """Hold the twin on measurements of some recordings; None where it cannot be held."""
        point, simulations = self.base.hypothesis.point(self.base.x), self.case.simulations
        runs = simulations.map(
            lambda k: simulations.run_parity(point, k, self.settings, measured[k]), measured
        )
        return runs if all(run.outcome.status == "ok" for run in runs) else None

    def run_one(self, k: int, measured: Column, held: Mapping[str, float]) -> Response | None:
        """Hold the twin on one measurement, with unrecorded FMU inputs at these values."""
        point = self.base.hypothesis.point(self.base.x)
        run = self.case.simulations.run_parity(point, k, self.settings, measured, held)
        return run if run.outcome.status == "ok" else None

    def effort(self, measured: Column, run: Response) -> Column:
        """Force that holds the plant, mean over each communication step, shape (rows,)."""
        return mean_effort(self.settings, measured, run, self.case.twin.step)

    def disturbed(self, k: int) -> Simulated:
        """Simulate one recording with a hidden disturbance and without being held.

        The disturbance is a torque in steps, or a like command where the twin has no torque port.
        """
        excitation = self.case.setting.excitation
        grid = self.case.simulations.records[k].plan.grid
        pattern = np.sign(np.sin(2.0 * np.pi * _DISTURBANCE_HZ * (grid - grid[0])))
        ports = self.base.simulated[k].response.ports
        hidden: dict[str, Column] = {}
        if "torque" in ports:
            hidden = {"torque": DISTURBANCE * excitation.torque * pattern}
        elif "command" in ports:
            hidden = {"command": DISTURBANCE * excitation.command * pattern}
        point = self.base.hypothesis.point(self.base.x)
        return self.case.simulations.run_one(point, k, excitation=hidden)


def hold(case: Case, base: Fitted, position: str) -> HeldTwin:
    """Find the ports by which a twin can be made to follow its recordings.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    base : Fitted
        The model that is held.
    position : str
        Output that was recorded as the position.
    """
    ports = base.simulated[0].response.ports
    settings: dict[str, float] = {}
    if "torque" in ports:
        parameters = base.hypothesis.point(base.x).parameters
        inertia = parameters.get(case.setting.inertia or "")
        loop = tracking_loop(inertia or case.setting.excitation.shaft_inertia, [], HOLDING_RAD_S)
        settings |= loop.settings
    if "sensor" in ports:
        settings["tracking.sensor"] = 1.0
        settings["tracking.sensor_included"] = float(reads_back(case, base))
    return HeldTwin(case, base, position, settings)


def reads_back(case: Case, base: Fitted) -> bool:
    """Whether the state `position` contains the sensor port's signal.

    A simulated step at the port shows in the state at once, or only as the shaft follows.
    """
    run = base.simulated[0].response
    if "position" not in run.states or "sensor" not in run.ports:
        return False
    rows = run.states["position"].size
    middle, size = rows // 2, 1e-3 * case.setting.excitation.stroke
    column = np.where(np.arange(rows) < middle, 0.0, size)
    point = base.hypothesis.point(base.x)
    stepped = case.simulations.run_one(point, 0, excitation={"sensor": column})
    moved = stepped.response.states["position"] - run.states["position"]
    return bool(np.median(moved[middle + 1 : middle + 3]) > 0.5 * size)


def mean_effort(
    settings: Mapping[str, float], measured: Column, run: Response, step: float
) -> Column:
    """Torque of the tracking loop, mean over each communication step, shape (rows,).

    A sample of the torque at one instant would miss the shaft's change of speed within a step.

    Parameters
    ----------
    settings : mapping of str to float
        Of the loop.
    measured : ndarray, shape (rows,)
        [FMU's unit] Position that the loop follows.
    run : Response
        Of the twin that it holds.
    step : float
        [s] Communication step.
    """
    if settings.get("tracking.sensor"):
        error = run.ports["sensor"]
    else:
        error = measured - run.states["position"]
    following = np.append(error[1:], error[-1])
    spring = 0.5 * settings["tracking.kp"] * (error + following)
    return np.asarray(spring + settings["tracking.kd"] * (following - error) / step)
