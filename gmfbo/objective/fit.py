"""Error of a simulated trajectory against a recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import RecordingError
from gmfbo.recordings.recording import Recording, Trajectory


def compare_at(trajectory: Recording, recording: Recording, signal: str) -> NDArray[np.float64]:
    """Residual, recorded minus simulated, at the recording's own times.

    The simulated grid is interpolated linearly, and taken exactly where times coincide.

    Parameters
    ----------
    trajectory : Recording
        Simulated run.
    recording : Recording
        Measured run; n rows.
    signal : str
        Name of a signal that both hold.

    Returns
    -------
    ndarray, shape (n,)
        [unit of the signal]; NaN where the signal was not sampled, and where the simulation
        had not begun or had stopped.

    Raises
    ------
    RecordingError
        One of the two has no such signal.
    """
    measured, simulated = recording.signal(signal), trajectory.signal(signal)
    known = np.isfinite(simulated)
    if not known.any():
        return np.full(measured.shape, np.nan)
    grid = trajectory.time[known]
    # Equal instants may differ in the last place: one grid counts from zero, one is read.
    slack = 1e-9 * max(1.0, abs(float(grid[0])), abs(float(grid[-1])))
    covered = (recording.time >= grid[0] - slack) & (recording.time <= grid[-1] + slack)
    residual = measured - np.interp(recording.time, grid, simulated[known])
    return np.where(covered, residual, np.nan)


def scored_rows(recording: Recording, signal: str, *, warmup: float = 0.0) -> NDArray[np.bool_]:
    """Rows that are scored: sampled, within `use`, and after the warm-up.

    Parameters
    ----------
    recording : Recording
        Measured run; n rows.
    signal : str
        Name of the signal.
    warmup : float
        [s] From the first row: simulated but not scored.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the residual is scored.
    """
    rows = np.isfinite(recording.signal(signal))
    rows &= recording.time >= recording.time[0] + warmup
    if recording.use is not None:
        first, last = recording.use
        rows &= (recording.time >= first) & (recording.time <= last)
    return rows


def nrmse(
    trajectory: Recording, recording: Recording, signal: str, *, warmup: float = 0.0
) -> float:
    """RMS residual over the range of the recorded signal, dimensionless.

    Parameters
    ----------
    trajectory : Recording
        Simulated run.
    recording : Recording
        Measured run.
    signal : str
        Name of a signal that both hold.
    warmup : float
        [s] From the first row: simulated but not scored.

    Returns
    -------
    float
        Zero for a perfect twin; 0.01 is one percent of the recorded range.

    Raises
    ------
    RecordingError
        Nothing is left to score, the simulation ended before it, or the signal never moves.
    """
    rows = scored_rows(recording, signal, warmup=warmup)
    label = recording.name or "recording"
    if not rows.any():
        raise RecordingError(
            f"{label}: no row of '{signal}' to score; widen '# use' or shorten the warm-up"
        )
    residual = compare_at(trajectory, recording, signal)[rows]
    if not np.isfinite(residual).all():
        raise RecordingError(f"{label}: '{signal}' is not simulated to the end{_why(trajectory)}")
    measured = recording.signal(signal)[rows]
    extent = float(np.ptp(measured))
    if extent == 0.0:
        raise RecordingError(
            f"{label}: '{signal}' is constant, so its error has no range to be divided by"
        )
    return float(np.sqrt(np.mean(residual**2)) / extent)


def _why(trajectory: Recording) -> str:
    if isinstance(trajectory, Trajectory) and trajectory.status != "ok":
        at = "" if trajectory.stopped_at is None else f" at {trajectory.stopped_at:g} s"
        return f": the run {trajectory.status}{at}"
    return f"; it covers {trajectory.time[0]:g} to {trajectory.time[-1]:g} s"
