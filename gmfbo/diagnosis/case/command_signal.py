"""Which recorded signal is the controller's command."""

from __future__ import annotations

from gmfbo.diagnosis.case.case import Case


def command_of(case: Case) -> str | None:
    """Output that is the state `command`; None where the twin compares none.

    Parameters
    ----------
    case : Case
        Twin and recordings.
    """
    wanted = case.twin.file.states.get("command")
    for name, entry in case.twin.file.outputs.items():
        if wanted is not None and entry.variable == wanted:
            return name
    return None
