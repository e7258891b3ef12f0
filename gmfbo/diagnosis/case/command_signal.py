"""Find the recorded signal that is the controller's command."""

from __future__ import annotations

from gmfbo.diagnosis.case.case import Case


def command_of(case: Case) -> str | None:
    """Output with the role `command`; None where the twin file compares no such output."""
    wanted = case.twin.file.states.get("command")
    for name, entry in case.twin.file.outputs.items():
        if wanted is not None and entry.variable == wanted:
            return name
    return None
