"""Whether a corrected twin misleads: what it said of real runs before they were made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.trial import Trial
from gmfbo.retuning.real_runs import MOST_SAMPLES, rows_of
from gmfbo.sources.source import Source
from gmfbo.tuning.history import History
from gmfbo.tuning.playing import play

LEAST_RUNS = 2
"""Real runs that were predicted; one alone may be an accident."""


def misleads(history: History, given: Source, first: int) -> bool:
    """Whether corrected twins predicted the real runs worse than the twin as given does.

    A real run is predicted by the twin that was in force when its gains were chosen: its run
    beside it was made before any estimate knew the real one. The errors of the scored signal are
    compared as ratios, so that one wild run does not decide.

    Parameters
    ----------
    history : History
        All runs.
    given : Source
        The twin as the study file names it.
    first : int
        Number of the last real run that the first correction knew.
    """
    unseen = [
        trial
        for trial in history.of("IS1")
        if trial.number > max(first, history.changed_after) and trial.status == "ok"
    ]
    ratios = []
    for trial in unseen:
        predicted = next((t for t in history.of("IS2") if t.parent == trial.number), None)
        if predicted is None:
            continue
        before = play(given, trial.gains, history.experiment)
        ratios.append(
            np.log(_error(trial, predicted.recording, history))
            - np.log(_error(trial, before, history))
        )
    return len(ratios) >= LEAST_RUNS and float(np.sum(_latest(ratios))) > 0.0


def _latest(ratios: Sequence[float]) -> Sequence[float]:
    """The newest ones: what an early version got wrong is mended since."""
    return ratios[-4:]


def _error(trial: Trial, simulated: Recording, history: History) -> float:
    """RMS error of the scored signal [its unit]; its whole range where the twin failed."""
    signals = (history.experiment.signal,)
    times = history.experiment.scored_times(MOST_SAMPLES)
    measured = rows_of(trial.recording, signals, times)
    found = rows_of(simulated, signals, times)
    assert measured is not None, "a trial that ended well"
    size = float(np.ptp(measured)) or 1.0
    error = size if found is None else float(np.sqrt(np.mean((found - measured) ** 2)))
    # Two twins that are both right to the last digit are equally good.
    return max(error, 1e-3 * size)
