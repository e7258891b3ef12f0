"""A run that failed, as the result that it is."""

from __future__ import annotations

from gmfbo.recordings.recording import Recording, Status, Trajectory


def failed_run(
    reference: Recording,
    message: str,
    *,
    name: str = "",
    status: Status = "failed",
    seconds: float = 0.0,
    left: Recording | None = None,
) -> Trajectory:
    """Make the result of a run that failed.

    Parameters
    ----------
    reference : Recording
        What should have been followed.
    message : str
        What happened; made one line.
    name : str
        Of the source.
    status : str
        How it ended.
    seconds : float
        [s] Wall-clock time of the run.
    left : Recording or None
        What was recorded before the failure; its rows are kept.
    """
    kept = left or Recording(time=reference.time[:1], signals={})
    return Trajectory(
        time=kept.time,
        signals=kept.signals,
        units=kept.units,
        parameters=kept.parameters,
        schedules=kept.schedules,
        start_time=kept.start_time,
        name=name,
        status=status,
        message=" ".join(message.split()),
        stopped_at=float(kept.time[-1]),
        seconds=seconds,
    )
