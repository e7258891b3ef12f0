"""The signal that a loop controls, and how a recording shows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.fit import scored_rows
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.likeness import Likeness, likeness
from gmfbo.sources.twin.twin import FmuTwin

USUAL_NAME = "reference"
"""What most twin files call the input that a loop follows."""


def reference_of(twin: FmuTwin) -> str:
    """Input that the twin's loop follows, by whatever name; empty in open loop.

    Where no input is called `reference`, it is the only one in the unit of the axis' position or
    velocity that is no port of the axis, in a twin that computes the command itself. Where two
    inputs could be it, say a setpoint and the tilt of the base, neither is.
    """
    file = twin.file
    if USUAL_NAME in file.inputs:
        return USUAL_NAME
    given = {entry.variable for entry in file.inputs.values()}
    if file.states.get("command") in {None, *given}:
        return ""
    motions = [file.states[state] for state in ("position", "velocity") if state in file.states]
    units = {_unit(twin, variable) for variable in motions} - {""}
    ports = set(file.ports.values())
    asked = [
        name
        for name, entry in file.inputs.items()
        if entry.variable not in ports and _unit(twin, entry.variable) in units
    ]
    return asked[0] if len(asked) == 1 else ""


def controlled(twin: FmuTwin) -> str:
    """Output that has to follow the reference: that in its unit; empty in open loop."""
    reference = reference_of(twin)
    if not reference:
        return ""
    unit = _unit(twin, twin.file.inputs[reference].variable)
    alike = [name for name in twin.file.outputs if unit and unit_of(twin, name) == unit]
    return alike[0] if alike else ""


def unit_of(twin: FmuTwin, signal: str) -> str:
    return _unit(twin, twin.file.outputs[signal].variable)


def _unit(twin: FmuTwin, variable: str) -> str:
    return twin.binding.variables[variable].variable.si_unit


def seen_signal(
    twin: FmuTwin,
    recording: Recording,
    signal: str,
    run: Recording,
    expected: str = "",
    *,
    rows: NDArray[np.bool_] | None = None,
) -> Likeness | None:
    """Likeness of a recorded signal to that, or another, of a run, in rows that are scored."""
    scored = scored_rows(recording, signal, warmup=twin.file.warmup or 0.0)
    rows = scored if rows is None else scored & rows
    known = np.isfinite(run.signal(expected or signal))
    if rows.sum() < 3 or not known.any():
        return None
    other = np.interp(recording.time[rows], run.time[known], run.signal(expected or signal)[known])
    return likeness(recording.signal(signal)[rows], other)
