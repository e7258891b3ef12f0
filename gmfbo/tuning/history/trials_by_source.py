"""Trials of each source, sorted once: a study has thousands of twin runs."""

from __future__ import annotations

from collections.abc import Sequence

from gmfbo.recordings.store.trial import SourceName, Trial


class TrialsBySource:
    """Sorts what was added since it was last asked, all anew where trials were taken out."""

    def __init__(self) -> None:
        self._sorted: dict[SourceName, list[Trial]] = {}
        self._known = 0
        self._last: Trial | None = None

    def of(self, trials: Sequence[Trial], source: SourceName) -> list[Trial]:
        """Trials of one source, in order.

        Parameters
        ----------
        trials : sequence of Trial
            All of a study.
        source : str
            As in the store.
        """
        if self._known > len(trials) or (self._known and trials[self._known - 1] is not self._last):
            self._sorted, self._known = {}, 0
        for trial in trials[self._known :]:
            self._sorted.setdefault(trial.source, []).append(trial)
            self._known, self._last = self._known + 1, trial
        return list(self._sorted.get(source, ()))
