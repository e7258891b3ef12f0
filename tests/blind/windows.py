"""When a hidden effect shows: the true windows in time."""

from __future__ import annotations

import numpy as np

from tests.blind.truth import SAMPLE, TrueRun

AROUND_REVERSAL = 0.03
"""[s] Before and after a reversal."""

_MERGED = 0.02


def windows_of(kind: str, run: TrueRun, speed: float) -> list[tuple[float, float]]:
    """Windows [s] of an effect in a recording.

    Parameters
    ----------
    kind : str
        `reversals` of the velocity, `active` where the plant limits more than half of a sample,
        or "".
    run : TrueRun
        The true run with the effect.
    speed : float
        [position/s] A velocity beyond a tenth of it has a direction.
    """
    if kind == "reversals":
        direction = np.sign(run.velocity) * (np.abs(run.velocity) > 0.1 * speed)
        moving = np.flatnonzero(direction)
        turns = np.flatnonzero(np.diff(direction[moving]) != 0.0)
        spans = [
            (moving[k] * SAMPLE - AROUND_REVERSAL, moving[k + 1] * SAMPLE + AROUND_REVERSAL)
            for k in turns
        ]
    elif kind == "active":
        rows = np.flatnonzero(run.active > 0.5)
        spans = [(row * SAMPLE, (row + 1) * SAMPLE) for row in rows]
    else:
        spans = []
    return _merged(spans)


def _merged(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    merged: list[tuple[float, float]] = []
    for start, end in spans:
        if merged and start - merged[-1][1] < _MERGED:
            merged[-1] = (merged[-1][0], max(end, merged[-1][1]))
        else:
            merged.append((start, end))
    return [(round(max(0.0, start), 4), round(end, 4)) for start, end in merged]
