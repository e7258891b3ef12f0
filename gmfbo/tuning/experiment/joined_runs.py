"""Runs of several references as one recording, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording, Status, Trajectory


def join_runs(
    runs: Sequence[Recording],
    offsets: Sequence[float] | NDArray[np.float64],
    spans: Sequence[tuple[float, float]],
) -> Recording:
    """Join runs, one after the other.

    Parameters
    ----------
    runs : sequence of Recording
        At least one.
    offsets : sequence of float
        [s] Added to the times of each run.
    spans : sequence of (float, float)
        [s] First and last time of each reference; rows outside would overlap another run, and
        are left out.

    Returns
    -------
    Recording
        With all signals of all runs, NaN where a run lacks one. It is a `Trajectory` if one of
        the runs is, with the first status that is not `ok`.
    """
    kept = [_inside(run, *span) for run, span in zip(runs, spans, strict=False)]
    names = list(dict.fromkeys(name for run in runs for name in run.signals))
    columns = {
        name: np.concatenate(
            [
                run.signals[name][rows] if name in run.signals else np.full(rows.sum(), np.nan)
                for run, rows in zip(runs, kept, strict=True)
            ]
        )
        for name in names
    }
    time = np.concatenate(
        [run.time[rows] + offset for run, rows, offset in zip(runs, kept, offsets, strict=False)]
    )
    what: dict[str, Any] = {
        "time": time,
        "signals": columns,
        "units": {name: unit for run in runs for name, unit in run.units.items()},
        "name": runs[0].name,
        "parameters": runs[0].parameters,
        "start_time": runs[0].start_time,
    }
    if not any(isinstance(run, Trajectory) for run in runs):
        return Recording(**what)
    return Trajectory(**what, **_ending(runs, offsets))


def ended_by(run: Recording, status: Status, message: str) -> Trajectory:
    """Mark a run as ended early, and keep all its signals.

    Parameters
    ----------
    run : Recording
        The run.
    status : str
        Such as `failed` or `unsafe`.
    message : str
        Reason, in one line.
    """
    return Trajectory(
        time=run.time,
        signals=run.signals,
        units=run.units,
        name=run.name,
        parameters=run.parameters,
        start_time=run.start_time,
        status=status,
        message=message,
        seconds=run.seconds if isinstance(run, Trajectory) else run.duration,
    )


def _ending(runs: Sequence[Recording], offsets: Sequence[float] | NDArray[np.float64]) -> Any:
    seconds = sum(run.seconds if isinstance(run, Trajectory) else run.duration for run in runs)
    for number, run in enumerate(runs):
        if isinstance(run, Trajectory) and run.status != "ok":
            stopped = None if run.stopped_at is None else run.stopped_at + float(offsets[number])
            return {
                "status": run.status,
                "message": f"reference {number + 1}: {run.message}",
                "stopped_at": stopped,
                "seconds": seconds,
            }
    return {"seconds": seconds}


def _inside(run: Recording, first: float, last: float) -> NDArray[np.bool_]:
    """Rows within the reference; times may miss its ends by a part of a row."""
    slack = 0.4 * float(run.time[-1] - run.time[-2]) if len(run) > 1 else 0.0
    return np.asarray((run.time >= first - slack) & (run.time <= last + slack))
