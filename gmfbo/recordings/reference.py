"""References that a drive follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gmfbo.errors import InputError
from gmfbo.recordings.recording import Recording


def step_reference(
    step_size: float = 1.0,
    *,
    at: float = 0.1,
    horizon: float = 1.0,
    sample_time: float = 1e-3,
    start: float = 0.0,
    signal: str = "reference",
    unit: str = "rad",
) -> Recording:
    """Step of the reference at `at`, recorded for `horizon` after it.

    Parameters
    ----------
    step_size : float
        Height of the step [unit].
    at : float
        [s] Time of the step; rounded to a sample.
    horizon : float
        [s] Length after the step.
    sample_time : float
        [s] Between rows.
    start : float
        Reference before the step [unit].
    signal, unit : str
        Name and SI unit of the reference signal.

    Returns
    -------
    Recording
        round((at + horizon) / sample_time) + 1 rows from time 0.

    Raises
    ------
    InputError
        A time is negative or the sample time not positive.
    """
    if not (sample_time > 0.0 and at >= 0.0 and horizon > 0.0):
        raise InputError(
            f"step reference: expected sample_time > 0, at >= 0 and horizon > 0, "
            f"got {sample_time}, {at} and {horizon}"
        )
    rows = round((at + horizon) / sample_time) + 1
    values = np.full(rows, float(start))
    values[round(at / sample_time) :] = start + step_size
    return Recording(
        time=np.arange(rows, dtype=np.float64) * sample_time,
        signals={signal: values},
        units={signal: unit},
        name=f"step of {step_size:g} {unit}",
    )


def steps_reference(
    times: Sequence[float],
    levels: Sequence[float],
    *,
    horizon: float = 1.0,
    sample_time: float = 1e-3,
    start: float = 0.0,
    signal: str = "reference",
    unit: str = "rad",
) -> Recording:
    """Several steps, one after the other, recorded for `horizon` after the last.

    Parameters
    ----------
    times : sequence of float
        [s] Of the steps, increasing; each is rounded to a sample.
    levels : sequence of float
        Reference after each step [unit].
    horizon : float
        [s] Length after the last step.
    sample_time : float
        [s] Between rows.
    start : float
        Reference before the first step [unit].
    signal, unit : str
        Name and SI unit of the reference signal.

    Raises
    ------
    InputError
        There are not as many levels as times, the times do not increase by a sample or more, or
        a level equals the one before.
    """
    if not times or len(times) != len(levels):
        raise InputError(
            f"steps: expected one level for each time, got {len(times)} times and "
            f"{len(levels)} levels"
        )
    rows = [round(time / sample_time) for time in times]
    if rows[0] < 0 or any(after <= before for before, after in pairwise(rows)):
        raise InputError(
            f"steps: expected increasing times of 0 s or later, at least {sample_time:g} s "
            f"apart, got {list(times)}"
        )
    if any(after == before for before, after in pairwise([start, *levels])):
        raise InputError(f"steps: expected each level to differ from the one before: {levels}")
    count = rows[-1] + round(horizon / sample_time) + 1
    values = np.full(count, float(start))
    for row, level in zip(rows, levels, strict=True):
        values[row:] = level
    return Recording(
        time=np.arange(count, dtype=np.float64) * sample_time,
        signals={signal: values},
        units={signal: unit},
        name=f"{len(times)} steps",
    )


def sine_reference(
    amplitude: float,
    frequency: float,
    cycles: float,
    *,
    at: float = 0.1,
    sample_time: float = 1e-3,
    start: float = 0.0,
    signal: str = "reference",
    unit: str = "rad",
) -> Recording:
    """Sine about `start`, which begins at `at` and lasts some cycles.

    Parameters
    ----------
    amplitude : float
        Height of the sine over `start` [unit].
    frequency : float
        [Hz]
    cycles : float
        Number of cycles.
    at : float
        [s] Rest before the sine.
    sample_time : float
        [s] Between rows.
    start : float
        Middle of the sine, and the reference before it [unit].
    signal, unit : str
        Name and SI unit of the reference signal.

    Raises
    ------
    InputError
        The sample time gives fewer than two samples a half cycle.
    """
    if not 0.0 < frequency * sample_time < 0.25:
        raise InputError(
            f"sine: expected at least four samples a cycle, got {frequency:g} Hz with a sample "
            f"time of {sample_time:g} s"
        )
    rows = round((at + cycles / frequency) / sample_time) + 1
    time = np.arange(rows, dtype=np.float64) * sample_time
    since = np.maximum(time - at, 0.0)
    return Recording(
        time=time,
        signals={signal: start + amplitude * np.sin(2.0 * np.pi * frequency * since)},
        units={signal: unit},
        name=f"sine of {frequency:g} Hz",
    )


def recorded_reference(recording: Recording, column: str, *, signal: str) -> Recording:
    """One column of a recording as a reference; its other columns are left out.

    Parameters
    ----------
    recording : Recording
        With the column, such as an export of an oscilloscope.
    column : str
        Name of the column.
    signal : str
        Name that the reference gets.

    Raises
    ------
    RecordingError
        There is no such column.
    InputError
        The column holds no two values.
    """
    values = recording.signal(column)
    known = np.isfinite(values)
    if known.sum() < 2:
        raise InputError(f"{recording.name}: '{column}' holds fewer than two values")
    unit = recording.units.get(column)
    return Recording(
        time=recording.time[known],
        signals={signal: values[known]},
        units={} if unit is None else {signal: unit},
        name=recording.name,
        parameters=recording.parameters,
        schedules={name: each[known] for name, each in recording.schedules.items()},
    )


def disturbance_signal(port: str) -> str:
    """Name of the signal that drives a port of a twin: `torque_disturbance`.

    Parameters
    ----------
    port : str
        Name of the port, such as `torque`.
    """
    return f"{port}_disturbance"


def with_disturbance(reference: Recording, port: str, step: float, at: float) -> Recording:
    """Add a step at a port to a reference, as a second signal.

    Parameters
    ----------
    reference : Recording
        The reference.
    port : str
        Port at which the step acts, such as `torque`.
    step : float
        Height of the step [unit of the port]; the port adds it.
    at : float
        [s] When it begins; it lasts to the end.

    Raises
    ------
    InputError
        It begins after the end of the reference.
    """
    if not reference.time[0] <= at < reference.time[-1]:
        raise InputError(
            f"disturbance: expected at between {reference.time[0]:g} and "
            f"{reference.time[-1]:g} s, within the reference, got {at:g}"
        )
    # A time that was rounded when it was written still belongs to its row.
    slack = 1e-6 * reference.duration
    pushed = np.where(reference.time >= at - slack, float(step), 0.0)
    return replace(reference, signals={**reference.signals, disturbance_signal(port): pushed})


def followed_signal(reference: Recording) -> str:
    """Name of the signal that is followed: the first; a disturbance stands behind it.

    Parameters
    ----------
    reference : Recording
        The reference.
    """
    return next(iter(reference.signals))
