"""References that a drive follows."""

from __future__ import annotations

import numpy as np

from gmfbo.errors import InputError
from gmfbo.recordings.recording import Recording


def step_reference(
    step_size: float = 1.0,
    *,
    at: float = 0.1,
    horizon: float = 1.0,
    sample_time: float = 1e-3,
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
    values = np.zeros(rows)
    values[round(at / sample_time) :] = step_size
    return Recording(
        time=np.arange(rows, dtype=np.float64) * sample_time,
        signals={signal: values},
        units={signal: unit},
        name=f"step of {step_size:g} {unit}",
    )
