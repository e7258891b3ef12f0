"""Compared signals that stay at one value while an input moves: a dead channel, or a stall."""

from __future__ import annotations

import numpy as np

from gmfbo.plain_words import number
from gmfbo.recordings.recording import Recording
from gmfbo.sources.twin.twin import FmuTwin

CURE = "map another column, or check its channel, unless the axis stood still"


def still_signals(twin: FmuTwin, recording: Recording) -> dict[str, str]:
    """Compared signals that never change, with what is to be said of each.

    Parameters
    ----------
    twin : FmuTwin
        Tells which signals are compared, and which drive it.
    recording : Recording
        Run of the real axis.
    """
    moves = [name for name in twin.file.inputs if _range(recording, name) > 0.0]
    if not moves:
        return {}
    return {
        name: f"is {number(float(np.nanmax(recording.signal(name))))} in every row, while "
        f"{moves[0]} moves"
        for name in twin.file.outputs
        if _range(recording, name) == 0.0
    }


def still_lines(twin: FmuTwin, recording: Recording) -> list[str]:
    """The same as lines, with what to do.

    Parameters
    ----------
    twin : FmuTwin
        Tells which signals are compared, and which drive it.
    recording : Recording
        Run of the real axis.
    """
    name = recording.name or "recording"
    found = still_signals(twin, recording)
    return [f"{name}: {signal} {what}; {CURE}" for signal, what in found.items()]


def _range(recording: Recording, name: str) -> float:
    """Largest minus smallest value; NaN without two of them."""
    values = recording.signals.get(name, np.empty(0))
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size > 1 else np.nan
