"""Compared signals that a recording lacks, and what cannot be told without each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gmfbo.errors import did_you_mean
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

_WITHOUT = {
    "position": "the axis' motion is not compared, and neither its plant nor its controller is "
    "checked alone",
    "command": "the controller is not checked, and what the plant lacks shows in its motion alone",
}


@dataclass(frozen=True)
class MissingSignal:
    """A signal of [outputs] that a recording lacks.

    Attributes
    ----------
    recording, signal : str
        Names.
    what : str
        What is missing, with the nearest column.
    without : str
        What cannot be told without it.
    """

    recording: str
    signal: str
    what: str
    without: str


def missing_signals(twin: FmuTwin, recordings: Sequence[Recording]) -> list[MissingSignal]:
    """Find signals of [outputs] without any value.

    Parameters
    ----------
    twin : FmuTwin
        Tells which signals are compared.
    recordings : sequence of Recording
        Runs of the real axis.
    """
    file = twin.file
    roles = {variable: role for role, variable in file.states.items()}
    found = []
    for recording in recordings:
        others = [n for n in recording.signals if n not in file.inputs and n not in file.outputs]
        for name, entry in file.outputs.items():
            column = recording.signals.get(name)
            if column is not None and np.isfinite(column).any():
                continue
            role = name if name in _WITHOUT else roles.get(entry.variable, "")
            without = _WITHOUT.get(role, "effects that show in it alone are not found")
            wanted = entry.column or name
            what = f"no column {wanted}{_nearest(wanted, others)}"
            if column is not None:
                what = f"column {wanted} holds no value"
            found.append(MissingSignal(recording.name or "recording", name, what, without))
    return found


def _nearest(wanted: str, columns: Sequence[str]) -> str:
    """End of a message: the columns of that name in several groups, or else the nearest one."""
    groups = [name for name in columns if name.replace("/", ".").endswith(f".{wanted}")]
    if len(groups) < 2:
        return did_you_mean(wanted, columns)
    return f" but {len(groups)} in groups: {', '.join(repr(name) for name in groups[:4])}"
