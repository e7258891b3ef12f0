"""A failed run as a result."""

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
        Reference of the run.
    message : str
        Cause of the failure; made one line.
    name : str
        Of the source.
    status : str
        Status of the run.
    seconds : float
        [s] Wall-clock time of the run.
    left : Recording or None
        Recording up to the failure; its rows are kept.
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
