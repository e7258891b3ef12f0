"""The twin's runs at the gains of the real ones."""

from __future__ import annotations

from collections.abc import Iterable

from gmfbo.recordings.store.trial import Trial


def runs_beside(trials: Iterable[Trial]) -> dict[int, Trial]:
    """First twin run caused by each real run, by the real run's number.

    This twin run has the same gains; later ones of a real run are a closer look at other gains.
    """
    beside: dict[int, Trial] = {}
    for trial in trials:
        if trial.source == "IS2" and trial.parent is not None:
            beside.setdefault(trial.parent, trial)
    return beside
