"""Whether runs of one reference settled: their late error, or where it never rests its growth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gmfbo.objective.settled import LATE_SHARE, error_growth, late_error, run_noise
from gmfbo.objective.smoothing import smoothed
from gmfbo.recordings.recording import Recording, Trajectory

if TYPE_CHECKING:
    from gmfbo.tuning.experiment.experiment import ReferenceExperiment


def late_error_of(
    part: ReferenceExperiment, time: ArrayLike, responses: ArrayLike, noise: float | None = None
) -> NDArray[np.float64]:
    """Late error of many responses over their tolerance, shape (...).

    Where the reference ends constant, the response must come to rest there. Elsewhere, and where
    a disturbance alone moves the axis, the tracking error must not grow. The response is smoothed
    as that of the metrics is.

    Parameters
    ----------
    part : ReferenceExperiment
        The reference, with settling band and filter.
    time : array_like, shape (n,)
        [s]
    responses : array_like, shape (..., n)
        The scored signal of each run.
    noise : float, optional
        Standard deviation of its noise [unit of the signal]; estimated unless given.
    """
    times = np.asarray(time, dtype=float)
    values = smoothed(times, responses, part.terms.filter_s)
    span = _span(part)
    if span == 0.0 or not _ends_constant(part):
        error = values - part.target(times)
        scored = (times >= part.begin, times <= part.begin + part.horizon)
        return error_growth(times, error, scored=scored, size=span or None, noise=noise)
    # Of several steps the last one is looked at: before it there is no time to come to rest.
    last = part.steps[-1] if part.steps else None
    begin = part.begin if last is None else last.time
    end = part.begin + part.horizon
    return late_error(
        times,
        values,
        step_time=begin,
        target=float(part.target(np.array([end]))[0]),
        step_size=span if last is None else last.size,
        horizon=end - begin,
        band=part.terms.band,
        noise=noise,
        rest_until=part.begin,
    )


def noise_of_run(part: ReferenceExperiment, run: Recording) -> float:
    """Standard deviation of the noise of the scored signal [its unit] of a run that ended well.

    Parameters
    ----------
    part : ReferenceExperiment
        The reference.
    run : Recording
        With the scored signal.
    """
    response = run.signal(part.signal)
    known = ~np.isnan(response)
    times = run.time[known]
    values = smoothed(times, response[known], part.terms.filter_s)
    return run_noise(times, values, part.begin, part.horizon)


def late_error_of_run(part: ReferenceExperiment, run: Recording) -> float:
    """Late error of one run over its tolerance; infinite where it failed.

    Parameters
    ----------
    part : ReferenceExperiment
        The reference.
    run : Recording
        With the scored signal; rows where it was not sampled are left out.
    """
    response = run.signals.get(part.signal)
    if response is None or (isinstance(run, Trajectory) and run.status != "ok"):
        return np.inf
    sampled = ~np.isnan(response)
    if not sampled.any():
        return np.inf
    return float(late_error_of(part, run.time[sampled], response[sampled]))


def _span(part: ReferenceExperiment) -> float:
    """Range of the reference [its unit]; zero where a disturbance alone moves the axis."""
    return float(np.ptp(part.reference.signals[part.reference_signal]))


def _ends_constant(part: ReferenceExperiment) -> bool:
    """Whether the reference rests where a settled run would be looked at."""
    reference, end = part.reference, part.begin + part.horizon
    begin = part.steps[-1].time if part.steps else part.begin
    since = end - LATE_SHARE * (end - begin)
    late = part.target(np.append(reference.time[reference.time >= since], since))
    return bool(np.ptp(late) == 0.0)
