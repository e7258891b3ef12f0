"""How long the first reference is held before a run, so that the twin starts at rest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

WINDOW_S = 0.05
"""[s] Outputs that stay put over this time have settled."""

_WINDOWS = (1, 20, 100)
_RELATIVE = 1e-6
_ABSOLUTE = 1e-9  # [SI] rounding at standstill; far below any encoder's or drive's resolution


def steps_to_settle(probe: Callable[[int], NDArray[np.float64] | None], step: float) -> int:
    """Communication steps to hold the first reference for.

    Probes of 0.05, 1 and 5 s are made until one settles. A twin that is at rest from its start
    gets none, so that its run begins with its own start values. One that never settles (an
    open-loop plant under force, a limit cycle) gets none either: it begins where its FMU begins,
    and the warm-up is left out of the score.

    Parameters
    ----------
    probe : callable
        Told a number of steps, simulates them under the first reference and returns the outputs,
        shape (steps + 1, n_outputs), or None where the simulation ended early.
    step : float
        [s] Communication step.
    """
    window = max(1, round(WINDOW_S / step))
    for count in _WINDOWS:
        outputs = probe(count * window)
        if outputs is None:
            return 0
        swings = _swings(outputs, window, count)
        allowed = _RELATIVE * np.abs(outputs).max(axis=0) + _ABSOLUTE
        quiet = np.flatnonzero((swings <= allowed).all(axis=1))
        if quiet.size:
            return 0 if quiet[0] == 0 else (int(quiet[0]) + 1) * window
        if count > 1 and not _is_fading(swings, allowed):
            return 0
    return 0


def _swings(outputs: NDArray[np.float64], window: int, count: int) -> NDArray[np.float64]:
    """Peak-to-peak of each output in each window, shape (count, n_outputs)."""
    windows = outputs[1:].reshape(count, window, -1)
    swings: NDArray[np.float64] = np.ptp(windows, axis=1)
    return swings


def _is_fading(swings: NDArray[np.float64], allowed: NDArray[np.float64]) -> bool:
    """Whether every output that still moves moves less than half as much as it did."""
    return bool(((swings[-1] <= allowed) | (swings[-1] < 0.5 * swings.max(axis=0))).all())
