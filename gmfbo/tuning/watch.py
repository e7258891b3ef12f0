"""Report finished runs as `Progress` to a callback."""

from __future__ import annotations

import time

import numpy as np

from gmfbo.recordings.recording import Recording
from gmfbo.recordings.store.trial import Trial
from gmfbo.tuning.history.history import History
from gmfbo.tuning.query.progress import Phase, Progress, ProgressCallback
from gmfbo.tuning.query.request import TrialRequest


class Watch:
    """Watches one call of `Tuner.run`.

    Parameters
    ----------
    history : History
        Of the study.
    callback : callable, optional
        Called with each `Progress`.
    """

    def __init__(self, history: History, callback: ProgressCallback | None = None) -> None:
        self._history, self._callback = history, callback
        self._began, self._queries_before = time.perf_counter(), history.queries
        self._mismatch: float | None = None

    def tell(
        self, phase: Phase, trial: Trial, request: TrialRequest | None, news: str = ""
    ) -> None:
        """Report a finished run.

        Parameters
        ----------
        phase : str
            Purpose of the run.
        trial : Trial
            The run.
        request : TrialRequest or None
            The newest query; its mismatch and note are passed on.
        news : str
            News for the user, in place of the note.
        """
        if self._callback is None:
            return
        if request is not None and request.mismatch is not None:
            self._mismatch = request.mismatch
        history, best = self._history, self._history.best
        asked = phase == "query" and request is not None
        self._callback(
            Progress(
                phase=phase,
                iteration=history.queries,
                iterations=history.study.budget.most_queries,
                is1_runs=history.made,
                trial=trial.number,
                source=trial.source,
                gains=trial.gains,
                objective=trial.objective,
                status=trial.status,
                best_objective=best.objective if best else None,
                best_gains=best.gains if best else None,
                mismatch=self._mismatch,
                cost=history.cost,
                seconds=time.perf_counter() - self._began,
                seconds_left=self._seconds_left(),
                note=news or (request.note if asked and request is not None else ""),
                initial_runs=len(history.unprompted) + history.made,
                most_initial_runs=history.first_runs,
            )
        )

    def say(self, news: str) -> None:
        """Report a sentence that belongs to no run.

        Parameters
        ----------
        news : str
            For the user.
        """
        nothing = Trial(0, "IS2", {}, Recording(np.zeros(1), {}), np.nan, {})
        self.tell("news", nothing, None, news)

    def tell_used_up(self) -> None:
        """Say once that the twin may not run again."""
        budget, trials = self._history.twin_budget, self._history.trials
        if not budget.told and budget.used_up(trials):
            budget.told = True
            self.say(budget.reason(trials))

    def _seconds_left(self) -> float | None:
        """[s] Expected time left, by the mean time of a query and the budget that ends first."""
        history = self._history
        budget, done = history.study.budget, history.queries - self._queries_before
        if done <= 0:
            return None
        mean = (time.perf_counter() - self._began) / done
        return mean * budget.queries_left(history.queries, history.made)
