"""Why the controller cannot be checked, in words."""

from __future__ import annotations

from gmfbo.sources.twin_file.twin_file import TwinFile

OPEN_LOOP = "the twin is an open-loop plant"
"""Nothing in the twin computes a command."""


def why_no_sensor(file: TwinFile) -> str:
    """Say why nothing can be fed to a controller: there is none, or no port leads to it.

    Parameters
    ----------
    file : TwinFile
        Of the twin.
    """
    # What a port adds to a recorded signal is computed by no controller of the twin.
    is_recorded = file.ports.get("command") in {entry.variable for entry in file.inputs.values()}
    return OPEN_LOOP if is_recorded else "the twin has no sensor port"


def why_no_position(file: TwinFile) -> str:
    """Say why no recording can be fed to the controller, where the position was not recorded.

    Parameters
    ----------
    file : TwinFile
        Of the twin.
    """
    if "sensor" not in file.ports:
        return why_no_sensor(file)
    return "a recording has no position to feed it with; a speed loop is not checked so far"


def why_no_command(file: TwinFile) -> str:
    """Say what has to be written or recorded, where no recorded command is known.

    Parameters
    ----------
    file : TwinFile
        Of the twin.
    """
    wanted = file.states.get("command")
    if wanted is None:
        return (
            "the twin file states no command; write the variable that the controller computes "
            'as command = "VARIABLE" in [states], and name it in [outputs]'
        )
    return (
        f"[states] says that the command is {wanted}, which not every recording holds; record "
        'it, or write command = "VARIABLE" there with a command that was recorded'
    )
