"""Runs that were asked for and are not answered yet."""

from __future__ import annotations

from collections.abc import Mapping

from gmfbo.tuning.history.history import History
from gmfbo.tuning.history.standing import END
from gmfbo.tuning.query.request import TrialRequest


class Waiting:
    """Requests that have not become trials, taken up again from the log.

    Parameters
    ----------
    history : History
        Its `waiting` is kept in step.

    Attributes
    ----------
    real : dict of int to TrialRequest
        Real runs by trial number, in the order in which they were asked for.
    twin : TrialRequest or None
        Query of the twin that was decided on but not run.
    last : TrialRequest or None
        Newest request.
    over : bool
        Whether the last look found nothing more to ask for.
    """

    def __init__(self, history: History) -> None:
        store = history.store
        asked = TrialRequest.unanswered(store.events(), store.numbers)
        self._history = history
        self.real = {request.number: request for request in asked if request.source == "IS1"}
        history.waiting.update({number: one.gains for number, one in self.real.items()})
        twin = [request for request in asked if request.source == "IS2"]
        self.twin = twin[-1] if twin else None
        self.last = asked[-1] if asked else None
        self.over = False

    def add(self, request: TrialRequest) -> None:
        """Wait for a run.

        Parameters
        ----------
        request : TrialRequest
            Just asked for.
        """
        self.last = request
        if request.source == "IS2":
            self.twin = request
            return
        self.real[request.number] = request
        self._history.waiting[request.number] = request.gains

    def answered(self, *numbers: int) -> None:
        """Wait no more for real runs.

        Parameters
        ----------
        *numbers : int
            Of their trials.
        """
        for number in numbers:
            del self.real[number], self._history.waiting[number]

    def log_end(self) -> None:
        """Log that the study came to its end, where nothing more is to be asked for."""
        if self.over:
            self._history.store.log(END, real=self._history.made)

    def at(self, held: Mapping[str, float]) -> list[TrialRequest]:
        """Real runs that are waited for, at some values of gains.

        Parameters
        ----------
        held : mapping of str to float
            Gains and their values; empty for all runs.
        """
        return [
            request
            for request in self.real.values()
            if all(request.gains[name] == held[name] for name in held)
        ]
