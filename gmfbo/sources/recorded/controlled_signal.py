"""The signal that a loop controls, and how a recording shows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.objective.fit import scored_rows
from gmfbo.recordings.recording import Recording
from gmfbo.sources.recorded.likeness import Likeness, likeness
from gmfbo.sources.twin.twin import FmuTwin


def controlled(twin: FmuTwin) -> str:
    """Output that has to follow the reference: that in its unit; empty in open loop."""
    file, variables = twin.file, twin.binding.variables
    if "reference" not in file.inputs:
        return ""
    unit = variables[file.inputs["reference"].variable].variable.si_unit
    alike = [
        n
        for n, e in file.outputs.items()
        if unit and variables[e.variable].variable.si_unit == unit
    ]
    return alike[0] if alike else ""


def unit_of(twin: FmuTwin, signal: str) -> str:
    return twin.binding.variables[twin.file.outputs[signal].variable].variable.si_unit


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
