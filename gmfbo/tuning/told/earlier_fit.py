"""Whether a run that was made earlier counts in this study, and the part of it that does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gmfbo.errors import InputError
from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.space import same_gain
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.study_file.gain_choice import GainChoice


def why_not(made: Mapping[str, float], known: Mapping[str, float], gains: GainChoice) -> str:
    """Why this study could not have asked for a run; empty where it could.

    A gain that was fixed may be free now and the reverse, and the box may have grown or shrunk.

    Parameters
    ----------
    made : mapping of str to float
        Gains of the run, tuned and fixed ones.
    known : mapping of str to float
        These, and further parameters that were in force.
    gains : GainChoice
        Tuned and held gains of this study.
    """
    wanted = (*gains.space.names, *gains.fixed)
    for name in wanted:
        if name not in known:
            return f"{name} is not said"
    for name in made:
        if name not in wanted:
            return f"{name} was set, which [gains] does not name; a number there holds it"
    for gain in gains.space.gains:
        if not gain.low <= known[gain.name] <= gain.high:
            return f"{gain.name} lies outside [{gain.low:g}, {gain.high:g}]"
    for name, value in gains.fixed.items():
        if not same_gain(known[name], value):
            return f"{name} is not {value:g}, at which it is held"
    return ""


def cut_to(run: Recording, played: ExperimentSeries, experiment: ExperimentSeries) -> Recording:
    """A run as long as this study would have made it; a failed run stays as it is.

    Parameters
    ----------
    run : Recording
        Joined, as it was played.
    played : ExperimentSeries
        The references that it followed, at least as long as those of this study.
    experiment : ExperimentSeries
        Experiment of this study.
    """
    if isinstance(run, Trajectory) and run.status != "ok":
        return run
    each = [
        _until(played.part_of(run, number), float(part.reference.time[-1]))
        for number, part in enumerate(experiment.parts)
    ]
    return experiment.join(each)


def _until(run: Recording, end: float) -> Recording:
    """The rows of a run up to a time [s]."""
    rows = run.time <= end + 1e-9 * max(abs(end), 1.0)
    if rows.all():
        return run
    signals = {name: values[rows] for name, values in run.signals.items()}
    return replace(run, time=run.time[rows], signals=signals)


def refuse_other_experiment(
    label: str, played: ExperimentSeries, experiment: ExperimentSeries
) -> None:
    """Raise unless the references are the same as long as this study plays them.

    Parameters
    ----------
    label : str
        What was played, for the message.
    played : ExperimentSeries
        References of earlier runs.
    experiment : ExperimentSeries
        References of this study.

    Raises
    ------
    InputError
        They differ, or ended before the horizon of this study.
    """
    same = len(played.parts) == len(experiment.parts) and all(
        _begins_with(one.reference, other.reference)
        and one.begin == other.begin
        and one.horizon >= other.horizon
        for one, other in zip(played.parts, experiment.parts, strict=True)
    )
    if not same:
        raise InputError(
            f"{label}: expected the same [reference] as here ({_steps(experiment)}), as long or "
            f"longer, it played {_steps(played)}; runs of another one cannot be compared"
        )


def _begins_with(longer: Recording, shorter: Recording) -> bool:
    count = shorter.time.size
    return (
        longer.time.size >= count
        and np.allclose(longer.time[:count], shorter.time, rtol=0.0, atol=1e-9)
        and longer.signals.keys() == shorter.signals.keys()
        and all(
            np.array_equal(values[:count], shorter.signals[name])
            for name, values in longer.signals.items()
        )
    )


def _steps(experiment: ExperimentSeries) -> str:
    return ", ".join(
        f"{part.described}, scored for {part.horizon:g} s" for part in experiment.parts
    )
