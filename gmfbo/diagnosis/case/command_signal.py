"""Find the recorded signal that is the controller's command."""

from __future__ import annotations

from gmfbo.diagnosis.case.case import Case

_TORQUES = ("N.m", "N")


def command_of(case: Case) -> str | None:
    """Output with the role `command`; None where the twin file compares no such output."""
    wanted = case.twin.file.states.get("command")
    for name, entry in case.twin.file.outputs.items():
        if wanted is not None and entry.variable == wanted:
            return name
    return None


def torque_of_command(case: Case) -> float | None:
    """[FMU's unit of the torque port / SI unit] Of the command; None where it is no torque."""
    binding, command = case.twin.binding, command_of(case)
    port = binding.file.ports.get("torque")
    if command is None or port is None:
        return None
    acting = binding.variables[port].variable
    made = binding.variables[binding.file.outputs[command].variable].variable
    same = made.si_unit == acting.si_unit and made.si_unit in _TORQUES
    return 1.0 / acting.to_si if same else None
