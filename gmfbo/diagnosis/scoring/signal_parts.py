"""Roles and priors of a rig's signals, before any fit."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from gmfbo.diagnosis.scoring.nuisances import Alignment, alignment_of
from gmfbo.sources.binding.binding import Binding


@dataclass(frozen=True, eq=False)
class Rig:
    """Roles and priors of a rig's signals.

    Attributes
    ----------
    position : str or None
        Output that is the recorded position.
    positions : frozenset of str
        Outputs in the position's unit.
    alignments : mapping of str to Alignment
        Priors of the nuisances by signal.
    position_to_si : float
        [SI unit / FMU's unit] Of the position.
    """

    position: str | None
    positions: frozenset[str]
    alignments: Mapping[str, Alignment]
    position_to_si: float


def describe_rig(binding: Binding, present: Collection[str]) -> Rig:
    """Find the position signals, and the priors of all signals' nuisances.

    Parameters
    ----------
    binding : Binding
        The twin.
    present : collection of str
        Recorded signals; another one is not taken for a position.
    """
    outputs, states = binding.file.outputs, binding.file.states
    unit = {
        name: binding.variables[entry.variable].variable.si_unit for name, entry in outputs.items()
    }
    position = _position_signal(binding, present)
    if position is not None:
        wanted = unit[position]
    elif "position" in states:
        wanted = binding.variables[states["position"]].variable.si_unit
    else:
        wanted = ""
    positions = frozenset(n for n in present if n in unit and wanted and unit[n] == wanted)
    command = states.get("command") if "command" in binding.file.ports else None
    alignments = {
        name: alignment_of(
            entry, is_position=name in positions, is_command=entry.variable == command
        )
        for name, entry in outputs.items()
    }
    factor = 1.0
    if "position" in states:
        factor = binding.variables[states["position"]].variable.to_si
    return Rig(position, positions, alignments, factor)


def speed_scales(binding: Binding, rig: Rig) -> dict[str, float]:
    """[SI unit / FMU's unit] Of the output that shows the speed: the position, or the velocity.

    Parameters
    ----------
    binding : Binding
        The twin.
    rig : Rig
        Of its signals.
    """
    if rig.position is not None:
        return {rig.position: rig.position_to_si}
    wanted = binding.file.states.get("velocity")
    outputs = binding.file.outputs.items()
    return {n: binding.variables[wanted].variable.to_si for n, e in outputs if e.variable == wanted}


def _position_signal(binding: Binding, present: Collection[str]) -> str | None:
    """Output that is the state `position`, by its variable, its name or its unit."""
    outputs, state = binding.file.outputs, binding.file.states.get("position")
    candidates = [name for name in outputs if name in present]
    same = [name for name in candidates if outputs[name].variable == state]
    if same:
        return same[0]
    if "position" in candidates:
        return "position"
    if state is None:
        return None
    unit = binding.variables[state].variable.si_unit
    alike = [
        n
        for n in candidates
        if binding.variables[outputs[n].variable].variable.si_unit == unit and unit
    ]
    return alike[0] if alike else None
