"""How long each stage of a long computation took."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

Progress = Callable[[str, float], None]


class StageTimes:
    """Progress that is passed on, and the time between its stages.

    Parameters
    ----------
    told : callable (str, float)
        Called with each stage and the share done, as this is.
    first : str
        Name of the stage that runs until the first call.
    ended : callable (str, float), optional
        Called with each stage that ended and how long it took [s]. A stage that is told several
        times in a row ends once.
    clock : callable () -> float, optional
        [s] Monotonic time.
    """

    def __init__(
        self,
        told: Progress,
        first: str,
        ended: Progress | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._told, self._ended, self._clock = told, ended, clock
        self._stage, self._since = first, clock()
        self._seconds: dict[str, float] = {}

    def __call__(self, stage: str, share: float) -> None:
        """Go on to a stage, or stay in it."""
        if stage != self._stage:
            now = self._clock()
            taken = now - self._since
            self._seconds[self._stage] = self._seconds.get(self._stage, 0.0) + taken
            if self._ended is not None:
                self._ended(self._stage, taken)
            self._stage, self._since = stage, now
        self._told(stage, share)

    @property
    def seconds(self) -> Mapping[str, float]:
        """[s] Of each stage that ended, in the order of their first; one met again is summed."""
        return dict(self._seconds)
