"""Real runs of a study, prepared for comparison with a simulated twin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.recordings.recording import Recording, Trajectory
from gmfbo.recordings.store.trial import Trial
from gmfbo.retuning.calibration import RealRun
from gmfbo.sources.twin.twin import FmuTwin
from gmfbo.sources.twin.twin_at import TwinAt
from gmfbo.tuning.experiment.experiment_series import ExperimentSeries
from gmfbo.tuning.experiment.run_values import at_times
from gmfbo.tuning.history.history import History
from gmfbo.tuning.study.playing import play
from gmfbo.version import __version__

MOST_SAMPLES = 300
"""Samples of a run that are compared."""


def usable_trials(history: History) -> list[Trial]:
    """Real runs with signals that ended well, without those from before the plant changed."""
    return [
        trial
        for trial in history.of("IS1")
        if trial.status == "ok" and not trial.bare and trial.number > history.changed_after
    ]


def compared_signals(trials: Sequence[Trial], twin: FmuTwin) -> tuple[str, ...]:
    """Outputs of the twin that all of these runs hold."""
    return tuple(
        name
        for name in twin.file.outputs
        if all(
            name in trial.recording.signals and np.isfinite(trial.recording.signal(name)).sum() >= 2
            for trial in trials
        )
    )


def real_run(
    trial: Trial, signals: Sequence[str], twin: FmuTwin, experiment: ExperimentSeries
) -> RealRun:
    """Make a real run for comparison with a twin.

    Parameters
    ----------
    trial : Trial
        Of the axis.
    signals : sequence of str
        Compared signals.
    twin : FmuTwin
        Simulated at the same gains; other parameters of the trial stay hidden from it.
    experiment : ExperimentSeries
        References that were played.
    """
    time = trial.recording.time
    times = np.linspace(time[0], time[-1], min(MOST_SAMPLES, time.size))

    def simulate(settings: dict[str, float]) -> NDArray[np.float64] | None:
        run = play(TwinAt(twin, settings), trial.gains, experiment)
        return rows_of(run, signals, times)

    measured = rows_of(trial.recording, signals, times)
    assert measured is not None, "a trial that ended well"
    return RealRun(trial.number, measured, simulate)


def rows_of(
    run: Recording, signals: Sequence[str], times: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Signals at given times, shape (s, m); None where the run failed."""
    if isinstance(run, Trajectory) and run.status != "ok":
        return None
    return np.stack([at_times(run, run.signal(name), times) for name in signals])


def plain_recordings(
    trials: Sequence[Trial], twin: FmuTwin, experiment: ExperimentSeries
) -> list[Recording]:
    """Real runs as recordings for a diagnosis, one for each reference.

    A trial of an FMU plant holds the true parameters of the plant. They are the answer, so only
    the gains go into the recording.

    Parameters
    ----------
    trials : sequence of Trial
        Of the axis.
    twin : FmuTwin
        Names the signals.
    experiment : ExperimentSeries
        References that were played; a recording that lacks its reference gets it from here.
    """
    recordings = []
    for trial in trials:
        for part, reference in enumerate(experiment.references):
            run = experiment.part_of(trial.recording, part)
            signals = {
                name: np.interp(run.time, reference.time, values)
                for name, values in reference.signals.items()
                if name in twin.file.inputs
            }
            signals |= {
                name: values
                for name, values in run.signals.items()
                if name in twin.file.inputs or name in twin.file.outputs
            }
            name = f"run {trial.number}" + (f", reference {part + 1}" if part else "")
            recordings.append(
                Recording(
                    time=run.time,
                    signals=signals,
                    units={n: unit for n, unit in run.units.items() if n in signals},
                    name=name,
                    parameters=dict(trial.gains),
                    # An FMU plant logs by the convention of gmfbo's own files.
                    written_by=run.written_by or (__version__ if trial.twin else ""),
                )
            )
    return recordings
