"""One recorded signal with its simulations, before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Curve:
    """A recorded signal with its simulations, for a plot; n rows.

    Attributes
    ----------
    recording : str
        Name of the recording.
    signal : str
        Name of the signal.
    unit : str
        Its unit.
    time : ndarray, shape (n,)
        [s] In the recording's own time.
    recorded : ndarray, shape (n,)
        [unit] As measured, aligned; NaN where it was not sampled.
    nominal : ndarray, shape (n,)
        [unit] The twin as it came.
    parameters_only : ndarray, shape (n,)
        [unit] The twin with its uncertain parameters refitted.
    augmented : ndarray, shape (n,)
        [unit] With the named physics; NaN where there is none.
    """

    recording: str
    signal: str
    unit: str
    time: NDArray[np.float64]
    recorded: NDArray[np.float64]
    nominal: NDArray[np.float64]
    parameters_only: NDArray[np.float64]
    augmented: NDArray[np.float64]
