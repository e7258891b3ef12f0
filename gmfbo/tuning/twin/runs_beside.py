"""The twin's runs at the gains of the real ones."""

from __future__ import annotations

from collections.abc import Iterable

from gmfbo.recordings.store.trial import Trial


def runs_beside(trials: Iterable[Trial]) -> dict[int, Trial]:
    """The twin's run that was made first because of each real run, by the real one's number.

    It is at the same gains; later ones that belong to a real run are a closer look around others.
    """
    beside: dict[int, Trial] = {}
    for trial in trials:
        if trial.source == "IS2" and trial.parent is not None:
            beside.setdefault(trial.parent, trial)
    return beside
