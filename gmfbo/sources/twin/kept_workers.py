"""Workers that go from one run of a twin to the next."""

from __future__ import annotations

import threading

from gmfbo.sources.worker.runner import Runner


class KeptWorkers:
    """Idle workers of one twin, until they are closed; several threads may take and give."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[Runner] = []
        self._is_closed = False

    def __len__(self) -> int:
        return len(self._idle)

    def take(self) -> Runner | None:
        """A worker, which is the caller's from now on; None where there is none."""
        with self._lock:
            return self._idle.pop() if self._idle else None

    def give(self, runner: Runner) -> None:
        """Keep a worker; it is ended where no more are kept.

        Parameters
        ----------
        runner : Runner
            Of the same twin.
        """
        with self._lock:
            if not self._is_closed:
                self._idle.append(runner)
                return
        runner.close()

    def close(self) -> None:
        """End all that are idle, and those that are given later."""
        with self._lock:
            idle, self._idle, self._is_closed = self._idle, [], True
        for runner in idle:
            runner.close()
