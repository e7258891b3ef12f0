"""A twin with an instance of physics.fmu before each FMU that owns a port."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from gmfbo.sources.binding.binding import Binding, content_of
from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.fmu_file.description import FmuDescription, read_description
from gmfbo.sources.fmu_file.job import Wire
from gmfbo.sources.fmu_file.models import physics_fmu

PORT_OUTPUTS = {"torque": "torque", "command": "command", "sensor": "sensor"}
"""Output of physics.fmu that acts at each port."""


@dataclass(frozen=True)
class PhysicsInstance:
    """One instance of physics.fmu in the order of computation.

    Attributes
    ----------
    index : int
        Place in the order.
    ports : tuple of str
        Ports that it serves.
    variables : mapping of str to BoundVariable
        Variables of this instance, by their names in physics.fmu.
    """

    index: int
    ports: tuple[str, ...]
    variables: Mapping[str, BoundVariable]


@dataclass(frozen=True)
class AugmentedBinding:
    """FMUs and variables of a twin and of the physics before its ports.

    Attributes
    ----------
    binding : Binding
        The twin, its FMUs interleaved with physics.fmu.
    physics : tuple of PhysicsInstance
        In order of computation; empty for a twin without ports.
    wires : tuple of Wire
        From the twin's states to physics, and from physics to the ports.
    late : bool
        Whether the command is computed after physics, which then sees the command of the
        communication step before.
    command_input : str or None
        Recorded signal that drives the input at the command port; it passes through physics,
        whose effects see it without delay.
    """

    binding: Binding
    physics: tuple[PhysicsInstance, ...]
    wires: tuple[Wire, ...]
    late: bool
    command_input: str | None = None


def augment(binding: Binding) -> AugmentedBinding:
    """Place physics before the owners of the ports, so that it delays nothing by a step.

    Raises
    ------
    FmuFileError
        physics.fmu cannot run on this machine.
    """
    owners: dict[int, list[str]] = {}
    for port, name in binding.file.ports.items():
        if port in PORT_OUTPUTS:
            owners.setdefault(binding.variables[name].fmu, []).append(port)
    moved = {i: i + sum(owner <= i for owner in owners) for i in range(len(binding.fmus))}
    fmus: list[FmuDescription] = []
    content: list[str] = []
    physics_at: dict[int, int] = {}
    description = read_description(physics_fmu())
    description.library()
    physics_content = content_of(description.path) if owners else ""
    for i, fmu in enumerate(binding.fmus):
        if i in owners:
            physics_at[i] = len(fmus)
            fmus.append(description)
            content.append(physics_content)
        fmus.append(fmu)
        content.append(binding.content[i])
    variables = {
        name: replace(bound, fmu=moved[bound.fmu]) for name, bound in binding.variables.items()
    }
    instances = tuple(
        PhysicsInstance(
            physics_at[owner],
            tuple(ports),
            {
                name: BoundVariable(f"physics.{name}", physics_at[owner], variable)
                for name, variable in description.variables.items()
            },
        )
        for owner, ports in sorted(owners.items())
    )
    whole = replace(binding, fmus=tuple(fmus), content=tuple(content), variables=variables)
    wires = tuple(wire for instance in instances for wire in _wires(whole, instance))
    through = command_input(binding)
    late = through is None and _is_late(whole, instances)
    return AugmentedBinding(whole, instances, wires, late, through)


def command_input(binding: Binding) -> str | None:
    """Input that is the command itself: a plant in open loop; None of any other twin."""
    port = binding.file.ports.get("command")
    return next((n for n, e in binding.file.inputs.items() if e.variable == port), None)


def _wires(binding: Binding, instance: PhysicsInstance) -> list[Wire]:
    file, own = binding.file, instance.variables
    wires = [
        own[f"state.{state}"].wire_from(binding.variables[name])
        for state, name in file.states.items()
    ]
    if "command" not in file.states and "current" in file.states:
        # The actuator's input stands for its unknown output.
        current = binding.variables[file.states["current"]]
        wires.append(own["state.command"].wire_from(current))
    wires += [
        binding.variables[file.ports[port]].wire_from(own[PORT_OUTPUTS[port]])
        for port in instance.ports
    ]
    return wires


def _is_late(binding: Binding, instances: tuple[PhysicsInstance, ...]) -> bool:
    command = binding.file.states.get("command")
    if command is None:
        return False
    return any(
        "command" in instance.ports and binding.variables[command].fmu > instance.index
        for instance in instances
    )
