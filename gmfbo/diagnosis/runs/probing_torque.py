"""Typical torques of an axis, for probing it and scaling its effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.diagnosis.runs.simulated import Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.sources.twin.twin import FmuTwin

_MOST_ROWS = 0.995


def torque_guess(nominal: Sequence[Simulated], inertia: float | None) -> float:
    """First torque for probing the axis [FMU's unit].

    Parameters
    ----------
    nominal : sequence of Simulated
        The recordings simulated.
    inertia : float or None
        [FMU's unit] Of the twin.
    """
    states = nominal[0].response.states
    if "command" in states:
        return max(0.05 * float(np.abs(states["command"]).max()), 1e-9)
    if inertia is not None and "position" in states:
        return max(10.0 * inertia * float(np.ptp(states["position"])), 1e-9)
    return 1.0


def command_range(twin: FmuTwin, simulations: Simulations, nominal: Sequence[Simulated]) -> float:
    """[FMU's unit] Range of the command; 0 where none is simulated.

    A force that the twin lacks may ask for a larger command than all that the twin makes, so the
    recorded one counts as well, but for its rarest rows, which may be faults of a logger.

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    simulations : Simulations
        Of the recordings.
    nominal : sequence of Simulated
        The recordings simulated.
    """
    made = [run.response.states["command"] for run in nominal if "command" in run.response.states]
    if not made:
        return 0.0
    state = twin.file.states.get("command")
    outputs = {n: entry for n, entry in twin.file.outputs.items() if entry.variable == state}
    recorded = []
    for record in simulations.records:
        for signal in record.signals:
            if signal.name not in outputs:
                continue
            to_si = twin.binding.variables[outputs[signal.name].variable].variable.to_si
            # A zero that nobody knows is no force.
            zero = signal.values.mean() if outputs[signal.name].offset == "fit" else 0.0
            amount = np.abs(signal.values - zero) / abs(to_si)
            recorded.append(float(np.quantile(amount, _MOST_ROWS, method="lower")))
    return max([*recorded, *(float(np.abs(command).max()) for command in made)])


def moving_torque(
    twin: FmuTwin,
    simulations: Simulations,
    nominal: Sequence[Simulated],
    inertia: float | None,
) -> float:
    """Torque that moves an axis whose command is not simulated [FMU's unit].

    Parameters
    ----------
    twin : FmuTwin
        The user's twin.
    simulations : Simulations
        Of the recordings.
    nominal : sequence of Simulated
        The recordings simulated.
    inertia : float or None
        [FMU's unit] Of the twin.
    """
    recorded = _recorded_torque(twin, simulations)
    largest = max([recorded, *(float(np.abs(run.response.effort).max()) for run in nominal)])
    if inertia is None:
        return largest
    accelerations = []
    for record, run in zip(simulations.records, nominal, strict=True):
        if "velocity" in run.response.states:
            rate = np.gradient(run.response.states["velocity"], record.plan.grid)
            accelerations.append(float(np.quantile(np.abs(rate), 0.999)))
    return max([largest, *(inertia * a for a in accelerations)])


def _recorded_torque(twin: FmuTwin, simulations: Simulations) -> float:
    """[FMU's unit] Range of recorded outputs in the torque port's unit; 0 without one."""
    file, variables = twin.file, twin.binding.variables
    port = variables[file.ports["torque"]].variable if "torque" in file.ports else None
    if port is None or not port.si_unit:
        return 0.0
    alike = {
        name
        for name, entry in file.outputs.items()
        if variables[entry.variable].variable.si_unit == port.si_unit
    }
    return max(
        (
            float(np.abs(s.values - s.values.mean()).max()) / port.to_si
            for record in simulations.records
            for s in record.signals
            if s.name in alike
        ),
        default=0.0,
    )
