"""A feedback loop through the torque port that keeps an open-loop twin near its recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from gmfbo.diagnosis.runs.simulated import Tracking
from gmfbo.diagnosis.runs.simulations import Simulations
from gmfbo.diagnosis.scoring.signal_parts import Rig

TRACKING_RAD_S = 10.0
"""[rad/s] Bandwidth of the loop that keeps an open-loop twin from drifting off its recordings.

Low, so that it hardly reacts to the noise of what it follows: a loop that held the twin by force
would turn that noise into torque in proportion to its inertia, and the least inertia would fit.
"""

HOLDING_RAD_S = 90.0
"""[rad/s] Bandwidth of a tracking loop whose effort is read as the missing torque."""

_TRACKING_DAMPING = 0.8


def tracking_loop(
    inertia: float,
    measured: Sequence[NDArray[np.float64]],
    bandwidth: float = TRACKING_RAD_S,
) -> Tracking:
    """Design the loop that makes a shaft of this inertia follow its recordings.

    Parameters
    ----------
    inertia : float
        Torque per acceleration.
    measured : sequence of ndarray, shape (rows,)
        [FMU's unit] Recorded positions on the communication grid.
    bandwidth : float
        [rad/s]
    """
    settings = {
        "tracking.kp": inertia * bandwidth**2,
        "tracking.kd": 2.0 * _TRACKING_DAMPING * inertia * bandwidth,
    }
    return Tracking(settings, tuple(measured))


def track_recordings(simulations: Simulations, rig: Rig, inertia: float) -> None:
    """Keep an open-loop twin near its recordings, and score the position error that remains.

    Parameters
    ----------
    simulations : Simulations
        Changed in place: gets the loop, and records whose positions have a `driving` part.
    rig : Rig
        Where the recorded position is.
    inertia : float
        Torque per acceleration.
    """
    measured = []
    records = []
    for record in simulations.records:
        column = record.plan.recording.signal(rig.position or "")
        known = np.isfinite(column)
        grid = record.plan.grid
        on_grid = np.interp(grid, record.plan.recording.time[known], column[known])
        measured.append(on_grid / rig.position_to_si)
        fast = _untracked(on_grid, grid)
        signals = tuple(
            replace(s, driving=np.interp(s.time, grid, fast)) if s.name in rig.positions else s
            for s in record.signals
        )
        records.append(replace(record, signals=signals))
    simulations.tracking = tracking_loop(inertia, measured)
    simulations.replace_records(records)


def _untracked(column: NDArray[np.float64], grid: NDArray[np.float64]) -> NDArray[np.float64]:
    """Part of a position that is too fast for the loop to follow, shape (rows,); it is scored."""
    w = TRACKING_RAD_S
    closed = [1.0, 2.0 * _TRACKING_DAMPING * w, w**2]
    b, a = bilinear([1.0, 0.0, 0.0], closed, fs=1.0 / float(grid[1] - grid[0]))
    fast: NDArray[np.float64] = lfilter(b, a, column - column[0])
    return fast
