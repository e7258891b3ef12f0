"""What drives the ports of a twin: a recording, or for the command a wire."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gmfbo.errors import TwinFileError, did_you_mean
from gmfbo.recordings.reference import disturbance_signal
from gmfbo.sources.twin_file.entries import InputEntry
from gmfbo.sources.twin_file.twin_file import TwinFile


def with_driven_ports(file: TwinFile, ports: Sequence[str], label: str) -> TwinFile:
    """Let a recording drive ports, each by its signal of a disturbance.

    A signal of [inputs] that drives the same FMU input gives it up, since both would set it.

    Parameters
    ----------
    file : TwinFile
        The twin file.
    ports : sequence of str
        Names in [ports].
    label : str
        Name of the file, for messages.

    Raises
    ------
    TwinFileError
        The twin has no such port, or a wire drives it already.
    """
    inputs = dict(file.inputs)
    for port in ports:
        if port not in file.ports:
            have = ", ".join(file.ports) or "none"
            raise TwinFileError(
                f"{label}: a disturbance acts at port '{port}', [ports] has {have}; name the FMU "
                "input there" + did_you_mean(port, file.ports)
            )
        variable = file.ports[port]
        if variable in file.wires:
            raise TwinFileError(
                f"{label}: port '{port}' is the end of the wire to '{variable}', where no "
                "recording can add a disturbance; name an FMU input of its own in [ports]"
            )
        inputs = {name: entry for name, entry in inputs.items() if entry.variable != variable}
        inputs[disturbance_signal(port)] = InputEntry(variable=variable)
    return file.model_copy(update={"inputs": inputs})


def twin_file_at(path: Path) -> TwinFile:
    """Read a twin file; what drives a wired command port is the state `command` if it states none.

    Physics at that port needs what the controller asks for. A current behind the port holds what
    physics adds there: taken for the command, it would be answered again and again.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    TwinFileError
        As `TwinFile.read`.
    """
    file = TwinFile.read(path)
    source = file.wires.get(file.ports.get("command", ""))
    if source is None or "command" in file.states:
        return file
    return file.model_copy(update={"states": {**file.states, "command": source}})
