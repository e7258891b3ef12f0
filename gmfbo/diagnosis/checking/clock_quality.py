"""Quality of a recording's clock: even sampling and missing rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.diagnosis.checking.result import ClockQuality


def clock_quality(time: NDArray[np.float64], lost: NDArray[np.int64]) -> ClockQuality:
    """Judge how evenly rows were sampled.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s] Of the rows of the fastest signal.
    lost : ndarray of int
        Rows before which all signals jump.
    """
    steps = np.diff(time)
    usual = float(np.median(steps))
    places = np.round(steps / usual).clip(1.0)
    own = steps[places == 1.0]
    return ClockQuality(
        step=usual,
        jitter=float(np.abs(own / usual - 1.0).max()),
        lost_by_clock=int(np.sum(places - 1.0)),
        lost_at=tuple(float(time[row]) for row in lost if places[row - 1] == 1.0),
    )
