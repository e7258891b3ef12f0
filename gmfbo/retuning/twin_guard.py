"""Check whether a corrected twin misleads, by its predictions of real runs."""

from __future__ import annotations

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.retuning.real_runs import MOST_SAMPLES, rows_of, usable_trials
from gmfbo.sources.plants.source import Source
from gmfbo.tuning.history.history import History
from gmfbo.tuning.study.playing import play
from gmfbo.tuning.twin.runs_beside import runs_beside

LEAST_RUNS = 2
"""Fewest predicted real runs; a single one may be an outlier."""

NEWEST_RUNS = 4
"""Newest predictions that count, since later versions correct earlier errors."""


def misleads(history: History, given: Source, first: int) -> bool:
    """Whether corrected twins predicted the real runs worse than the twin as given does.

    The prediction of a real run is made by the twin in force when its gains were chosen, before
    any estimate used that run. Errors of the scored signal are compared as ratios, so that one
    outlier does not decide.

    Parameters
    ----------
    history : History
        All runs.
    given : Source
        The twin as the study file names it.
    first : int
        Number of the last real run used by the first correction.
    """
    beside = runs_beside(history.trials)
    unseen = [
        trial for trial in usable_trials(history) if trial.number > first and trial.number in beside
    ][-NEWEST_RUNS:]
    ratios = []
    for trial in unseen:
        before = play(given, trial.gains, history.experiment)
        ratios.append(
            np.log(_error(trial, beside[trial.number].recording, history))
            - np.log(_error(trial, before, history))
        )
    return len(ratios) >= LEAST_RUNS and float(np.sum(ratios)) > 0.0


def _error(trial: Trial, simulated: Recording, history: History) -> float:
    """RMS error of the scored signal [its unit]; its whole range where the twin failed."""
    signals = (history.experiment.signal,)
    times = history.experiment.scored_times(MOST_SAMPLES)
    measured = rows_of(trial.recording, signals, times)
    found = rows_of(simulated, signals, times)
    assert measured is not None, "a trial that ended well"
    size = float(np.ptp(measured)) or 1.0
    error = size if found is None else float(np.sqrt(np.mean((found - measured) ** 2)))
    # Two twins that are both exact are equally good.
    return max(error, 1e-3 * size)
