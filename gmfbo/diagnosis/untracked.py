"""What a slow loop that keeps a twin near its recordings leaves of a position."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

TRACKING_RAD_S = 10.0
"""[rad/s] Bandwidth of the loop that keeps an open-loop twin from drifting off its recordings.

Low, so that it hardly reacts to the noise of what it follows: a loop that held the twin by force
would turn that noise into torque in proportion to its inertia, and the least inertia would fit.
"""

TRACKING_DAMPING = 0.8


def left_by_tracking(column: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """Faster part of a position: what the loop leaves to be scored.

    Parameters
    ----------
    column : ndarray, shape (rows,)
        Position.
    spacing : float
        [s] Of its rows.
    """
    w = TRACKING_RAD_S
    closed = [1.0, 2.0 * TRACKING_DAMPING * w, w**2]
    b, a = bilinear([1.0, 0.0, 0.0], closed, fs=1.0 / spacing)
    fast: NDArray[np.float64] = lfilter(b, a, column - column[0])
    return fast
