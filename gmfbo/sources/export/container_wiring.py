"""Wiring of an augmented FMU: its FMUs, their wires and the variables it shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from gmfbo.errors import ExportError
from gmfbo.sources.binding.augmented_binding import PORT_OUTPUTS
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.binding.bound_variable import BoundVariable
from gmfbo.sources.fmu_file.job import ValueType

_SETTABLE = ("input", "parameter")


@dataclass(frozen=True)
class End:
    """A variable of an FMU inside the container.

    Attributes
    ----------
    member : str
        FMU, by its name in the container.
    variable : str
        By the FMU's own name.
    """

    member: str
    variable: str


@dataclass(frozen=True)
class Wiring:
    """FMUs of a container in order of computation, their wires and the variables shown outside.

    Attributes
    ----------
    members : dict of str to Path
        FMU files by their names in the container.
    wires : dict of End to End
        Input = output.
    settable : dict of str to list of End
        Inputs and parameters of the container by name, and the variables that they set. Entries
        set by start values only have names that no variable has.
    readable : dict of str to End
        Other variables of the container.
    starts : dict of str to float
        Start values [unit of the variable] over the FMUs' own, by names of `settable`.
    same_as : dict of str to str
        Variables of the container that share a value reference in their FMU.
    times : set of str
        Variables of the container that hold the time.
    hidden : list of str
        Inputs that only an internal wire drives.
    physics : list of str
        Members that are instances of physics.fmu with the effects.
    """

    members: dict[str, Path] = field(default_factory=dict)
    wires: dict[End, End] = field(default_factory=dict)
    settable: dict[str, list[End]] = field(default_factory=dict)
    readable: dict[str, End] = field(default_factory=dict)
    starts: dict[str, float] = field(default_factory=dict)
    same_as: dict[str, str] = field(default_factory=dict)
    times: set[str] = field(default_factory=set)
    hidden: list[str] = field(default_factory=list)
    physics: list[str] = field(default_factory=list)

    def start_unseen(self, variable: str, members: Sequence[str], value: float) -> None:
        """Give a hidden parameter of some FMUs a start value.

        Parameters
        ----------
        variable : str
            By the FMUs' own name.
        members : sequence of str
            The FMUs.
        value : float
            [unit of the variable]
        """
        name = f"unseen {variable} of {', '.join(members)}"
        self.settable[name] = [End(member, variable) for member in members]
        self.starts[name] = value


def wire_up(binding: Binding, physics_fmu: Path) -> Wiring:
    """Place physics before the owners of the ports and show every variable under its name.

    A port keeps its former signal: the user's own input, or the wire that ended there, passes
    through physics. Where it has both, an instance of physics.fmu with all effects off adds them:
    torque = port.torque + tracking.kp * (tracking.measured - state.position) with kp = 1.

    Raises
    ------
    ExportError
        Two ports are one input, or a port is no real number.
    """
    wiring = Wiring()
    ports = _ports(binding)
    for index, fmu in enumerate(binding.fmus):
        own = {name: port for name, port in ports.items() if binding.variables[name].fmu == index}
        if own:
            _add_physics(wiring, binding, physics_fmu, index, own)
        wiring.members[_member(index)] = fmu.path
    for target, source in binding.file.wires.items():
        if target not in ports:
            wiring.wires[_end(binding, target)] = _end(binding, source)
            wiring.hidden.append(target)
    _show(wiring, binding, ports)
    return wiring


def _ports(binding: Binding) -> dict[str, str]:
    """Known ports by the variable that they name."""
    ports: dict[str, str] = {}
    for port, name in binding.file.ports.items():
        if port not in PORT_OUTPUTS:
            continue
        if name in ports:
            raise ExportError(
                f"{binding.label}: ports '{ports[name]}' and '{port}' are both '{name}'; expected "
                "an input of its own for each, to export the augmented twin"
            )
        if binding.variables[name].variable.value_type != ValueType.REAL:
            raise ExportError(
                f"{binding.label}: port '{port}': expected a real input, '{name}' is of type "
                f"{binding.variables[name].variable.type}"
            )
        ports[name] = port
    return ports


def _add_physics(
    wiring: Wiring, binding: Binding, physics_fmu: Path, index: int, own: Mapping[str, str]
) -> None:
    physics = f"physics{index}.fmu"
    for name, port in own.items():
        through = End(physics, f"port.{port}")
        if name in binding.file.wires:
            adder = f"{port}_and_wire{index}.fmu"
            wiring.members[adder] = physics_fmu
            wiring.start_unseen("tracking.kp", [adder], 1.0)
            wiring.wires[End(adder, "port.torque")] = _end(binding, binding.file.wires[name])
            wiring.wires[through] = End(adder, "torque")
            through = End(adder, "tracking.measured")
        wiring.settable[name] = [through]
        start = binding.variables[name].variable.start
        if start:
            wiring.starts[name] = start
        wiring.wires[_end(binding, name)] = End(physics, PORT_OUTPUTS[port])
    wiring.members[physics] = physics_fmu
    wiring.physics.append(physics)
    for state, name in binding.file.states.items():
        wiring.wires[End(physics, f"state.{state}")] = _end(binding, name)
    if "command" not in binding.file.states and "current" in binding.file.states:
        # What the actuator is told stands for what it does.
        current = binding.file.states["current"]
        wiring.wires[End(physics, "state.command")] = _end(binding, current)


def _show(wiring: Wiring, binding: Binding, ports: Mapping[str, str]) -> None:
    first: dict[tuple[int, str, int], str] = {}
    for name, bound in _settable_first(binding):
        if name in ports or name in wiring.hidden:
            continue
        causality = bound.variable.causality
        if causality == "independent":
            wiring.times.add(name)
            continue
        family = "Integer" if bound.variable.type == "Enumeration" else bound.variable.type
        key = (bound.fmu, family, bound.variable.reference)
        if first.setdefault(key, name) != name:
            wiring.same_as[name] = first[key]
        elif causality in _SETTABLE:
            wiring.settable[name] = [_end(binding, name)]
        else:
            wiring.readable[name] = _end(binding, name)


def _settable_first(binding: Binding) -> Iterator[tuple[str, BoundVariable]]:
    """Variables, such that of those that share a value reference one that can be set is first."""
    for wanted in (True, False):
        for name, bound in binding.variables.items():
            if (bound.variable.causality in _SETTABLE) is wanted:
                yield name, bound


def _end(binding: Binding, name: str) -> End:
    bound = binding.variables[name]
    return End(_member(bound.fmu), bound.variable.name)


def _member(index: int) -> str:
    return f"fmu{index}.fmu"
