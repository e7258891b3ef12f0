"""How the twin's loop answers a push, and recordings that begin at rest at another place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gmfbo.diagnosis.runs.measured_excitation import Stiffness, probe_torque
from gmfbo.diagnosis.runs.probing_torque import torque_guess
from gmfbo.diagnosis.runs.scored_record import Record
from gmfbo.diagnosis.runs.simulated import Point, Simulated
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.signal_parts import Rig
from gmfbo.diagnosis.scoring.windows import first_difference, starts_elsewhere
from gmfbo.plain_words import listed

_RESTING = 3.0  # times the time to 2 %: what is left of a push of 10^5 times the noise is below it


def probed_loop(
    simulations: Simulations, nominal: list[Simulated], rig: Rig, inertia: float | None
) -> tuple[Stiffness | None, list[Simulated], list[str]]:
    """Push the shaft, and let recordings begin where they do, at rest.

    Parameters
    ----------
    simulations : Simulations
        Is told how long the loop takes to come to rest; its records may get other plans.
    nominal : list of Simulated
        The twin as it is.
    rig : Rig
        Positions.
    inertia : float or None
        [FMU's unit] Of the twin.

    Returns
    -------
    Stiffness or None
        None where no torque can be pushed.
    list of Simulated
        The twin as it is, from where the recordings begin.
    list of str
        A note, where that is elsewhere.
    """
    if "torque" not in nominal[0].response.ports:
        return None, nominal, []
    stiffness = _pushed(simulations, nominal, inertia)
    begun, names = begun_at_rest(simulations, nominal, rig, stiffness.loop_time)
    if not names:
        return stiffness, nominal, []
    note = f"{listed(names)}: begins at another place than the twin, which was held there before"
    # What it did before was a jump to where the recording begins, at the drive's limit.
    return _pushed(simulations, begun, inertia), begun, [note]


def _pushed(
    simulations: Simulations, nominal: Sequence[Simulated], inertia: float | None
) -> Stiffness:
    found = probe_torque(simulations, Point(), nominal, torque_guess(nominal, inertia))
    if np.isfinite(found.rest_time):
        step = float(np.diff(simulations.records[0].plan.grid[:2])[0])
        simulations.rest = int(np.ceil(_RESTING * found.rest_time / step))
    return found


def begun_at_rest(
    simulations: Simulations, nominal: list[Simulated], rig: Rig, loop_time: float
) -> tuple[list[Simulated], list[str]]:
    """Hold the first row before recordings that begin nearer to where that leads the twin.

    A log is often cut out of a longer one. The twin would begin at its own start, and jump.

    Parameters
    ----------
    simulations : Simulations
        That knows how long the loop takes to come to rest.
    nominal : list of Simulated
        The twin as it is.
    rig : Rig
        Positions.
    loop_time : float
        [s] Time constant of the closed loop.

    Returns
    -------
    list of Simulated
        The twin as it is, from where the recordings begin.
    list of str
        Names of those that begin elsewhere than they did.
    """
    rest, before = simulations.rest, simulations.records
    jumps = [
        record.plan.lead < rest and starts_elsewhere(record, run, rig.positions, loop_time)
        for record, run in zip(before, nominal, strict=True)
    ]
    if not any(jumps):
        return nominal, []
    simulations.replace_records(
        [
            replace(record, plan=record.plan.led_by(rest)) if jump else record
            for record, jump in zip(before, jumps, strict=True)
        ]
    )
    found = simulations.run([Point()])[0]
    nearer = [
        jump and run.finite and _apart(record, run, rig) < _apart(record, old, rig)
        for record, jump, run, old in zip(before, jumps, found, nominal, strict=True)
    ]
    chosen = zip(simulations.records, before, nearer, strict=True)
    simulations.replace_records([held if near else record for held, record, near in chosen])
    pairs = zip(found, nominal, nearer, strict=True)
    names = [record.name for record, near in zip(before, nearer, strict=True) if near]
    return [run if near else old for run, old, near in pairs], names


def _apart(record: Record, run: Simulated, rig: Rig) -> float:
    """Sum of the differences of the positions at the start [SI]."""
    pairs = zip(record.signals, run.signals, strict=True)
    return sum(abs(first_difference(s, v)) for s, v in pairs if s.name in rig.positions)
