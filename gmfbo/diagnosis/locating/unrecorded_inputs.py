"""Inputs of the twin that no recording holds, and whether its controller reads them.

A controller that also reads a feedforward or a second reference computes another command than
the recorded one as long as that input is unknown: this is no fault of the twin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.case.case import Case
from gmfbo.diagnosis.locating.held_twin import HeldTwin
from gmfbo.diagnosis.locating.parity import block_spread
from gmfbo.plain_words import listed, number
from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.twin.response import Response

_OWN = 0.5
"""Command per force that holds the plant, above which the command moved by itself.

A plant that is held passes on what its command adds: there the ratio is one in units of the
command. What acts on the plant alone is held off, and the command hardly moves: ratio zero.
"""

_ROUND_OFF = 1e-9  # of the command's rms: a run that is repeated gives less

Column = NDArray[np.float64]


def unrecorded_inputs(case: Case) -> dict[str, int]:
    """FMU inputs whose course nobody knows, and a recording that lacks each.

    Known are inputs that are recorded, wired, a port of physics, or held by [parameters].

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    file, binding = case.twin.file, case.twin.binding
    known = {*file.wires, *file.ports.values(), *file.parameters, *case.twin.parameters}
    signals = {entry.variable: name for name, entry in file.inputs.items()}
    found = {}
    for name, bound in binding.variables.items():
        if bound.variable.causality != "input" or bound.variable.value_type is None:
            continue
        lacking = [
            k
            for k, record in enumerate(case.simulations.records)
            if signals.get(name) not in record.plan.recording.signals
        ]
        if lacking and name not in known:
            found[name] = lacking[0]
    return found


def read_by_controller(case: Case, twin: HeldTwin, command: str) -> tuple[str, ...]:
    """Unrecorded inputs that change the command while the twin is held on its recordings.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    twin : HeldTwin
        Its controller reads the recorded measurement.
    command : str
        Output that is the controller's command.
    """
    return tuple(
        name
        for name, record in unrecorded_inputs(case).items()
        if _moves_command(case, twin, command, name, record)
    )


def _moves_command(case: Case, twin: HeldTwin, command: str, name: str, record: int) -> bool:
    measured = twin.recorded(record)
    bound = case.twin.binding.variables[name]
    usual = twin.run_one(record, measured, {name: _start(bound)})
    if usual is None:
        return False
    for value in _other_values(bound):
        run = twin.run_one(record, measured, {name: value})
        # Where the twin does not run with another value, nobody knows what the input does.
        if run is None or _moved_by_itself(case, twin, command, record, (usual, run)):
            return True
    return False


def why_not_judged(case: Case, names: Sequence[str]) -> str:
    """Say which inputs of the controller were not recorded, and what to write, in one line.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    names : sequence of str
        FMU inputs.
    """
    several = len(names) > 1
    starts = [number(_start(case.twin.binding.variables[name])) for name in names]
    lines = [f'"{name}" = {start}' for name, start in zip(names, starts, strict=True)]
    return (
        f"the controller also reads {', '.join(names)}, and {'they were' if several else 'it was'} "
        f"not recorded; the twin leaves {'them' if several else 'it'} at {listed(starts)}: if the "
        f"drive did so, write {listed(lines)} in [parameters]; if not, record "
        f"{'them as signals' if several else 'it as a signal'} of [inputs]"
    )


def _start(bound: BoundVariable) -> float:
    return bound.variable.start or 0.0


def _other_values(bound: BoundVariable) -> Sequence[float]:
    """[FMU's unit] One more and one less than the start value, as far as the FMU allows."""
    low, high = bound.variable.minimum, bound.variable.maximum
    if bound.variable.type == "Boolean":
        low, high = 0.0, 1.0
    values = (_start(bound) + 1.0, _start(bound) - 1.0)
    return [v for v in values if (low is None or v >= low) and (high is None or v <= high)]


def _moved_by_itself(
    case: Case, twin: HeldTwin, command: str, record: int, runs: tuple[Response, Response]
) -> bool:
    """Whether the command moved, and not just since the plant was pushed off the recording."""
    usual, run = runs
    grid = [case.simulations.records[record].plan.grid]
    moved = block_spread(grid, [run.held[command] - usual.held[command]])
    level = float(np.sqrt(np.mean(usual.held[command] ** 2)))
    if moved <= _ROUND_OFF * max(level, case.setting.excitation.command):
        return False
    return moved > _OWN * _pushed(case, twin, record, usual, run)


def _pushed(case: Case, twin: HeldTwin, record: int, usual: Response, run: Response) -> float:
    """[SI unit of the command] Change of the force that holds the plant; 0 without such a force."""
    if not twin.holds_plant:
        return 0.0
    measured = twin.recorded(record)
    grid = [case.simulations.records[record].plan.grid]
    effort = twin.effort(measured, run) - twin.effort(measured, usual)
    per_command = case.setting.excitation.torque / case.setting.excitation.command
    return block_spread(grid, [effort]) / per_command
