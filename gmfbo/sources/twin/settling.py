"""Settling time before a run: the first reference is held until the twin is at rest.

Probes of 0.05, 1 and 5 s under the first reference are made until one settles. A twin at rest from
its start is not held at all, so that its run begins with its own start values. A twin that never
settles (an open-loop plant under force, a limit cycle) also begins with its start values, and the
warm-up is left out of the score.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WINDOW_S = 0.05
"""[s] Time over which settled outputs do not move."""

_WINDOWS = (1, 20, 100)
_RELATIVE = 1e-6
_ABSOLUTE = 1e-9  # [SI] rounding at standstill; far below any encoder's or drive's resolution


def probe_lengths(step: float) -> list[int]:
    """Steps of the probes under the first reference, in the order of trial.

    Parameters
    ----------
    step : float
        [s] Communication step.
    """
    window = max(1, round(WINDOW_S / step))
    return [count * window for count in _WINDOWS]


def settled_after(outputs: NDArray[np.float64], step: float) -> int | None:
    """Steps that a probe took to settle: 0 where it was at rest from its start.

    Parameters
    ----------
    outputs : ndarray, shape (steps + 1, n_outputs)
        Of a probe, of one of `probe_lengths`.
    step : float
        [s] Communication step.

    Returns
    -------
    int or None
        None where it did not settle.
    """
    window = max(1, round(WINDOW_S / step))
    allowed = _RELATIVE * np.abs(outputs).max(axis=0) + _ABSOLUTE
    quiet = np.flatnonzero((_swings(outputs, window) <= allowed).all(axis=1))
    if not quiet.size:
        return None
    return 0 if quiet[0] == 0 else (int(quiet[0]) + 1) * window


def _swings(outputs: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """Peak-to-peak of each output in each window, shape (windows, n_outputs)."""
    windows = outputs[1:].reshape(-1, window, outputs.shape[1])
    swings: NDArray[np.float64] = np.ptp(windows, axis=1)
    return swings
