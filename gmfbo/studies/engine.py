"""Where units are done: in this process, on others of this machine, or on any executor."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing.connection import wait as wait_for_end
from typing import Any, Protocol

from gmfbo.errors import InputError, SimulationError
from gmfbo.studies.unit import Result, Unit
from gmfbo.studies.worker import carry_out


class Engine(Protocol):
    """Takes units and gives futures of what they came to.

    Attributes
    ----------
    dies_whole : bool
        A worker that dies takes all others with it.
    """

    dies_whole: bool

    @property
    def workers(self) -> int:
        """Units that are done at once."""
        ...

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Begin a unit; contents that its worker may lack go along."""
        ...

    def renew(self) -> None:
        """Make it usable again after it broke."""
        ...

    def stop(self) -> None:
        """Give up what is under way, now."""
        ...

    def close(self) -> None:
        """Give back what was opened."""
        ...


class InProcess:
    """This process: a unit is done when it is submitted."""

    dies_whole = True
    workers = 1

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Do a unit."""
        future: Future[Result] = Future()
        future.set_result(carry_out(unit, contents))
        return future

    def renew(self) -> None:
        """Nothing: it does not break."""

    def stop(self) -> None:
        """Nothing is under way."""

    def close(self) -> None:
        """Nothing was opened."""


class Processes:
    """Processes of this machine, started when they are first needed.

    Parameters
    ----------
    jobs : int
        How many.
    """

    dies_whole = True

    def __init__(self, jobs: int) -> None:
        self.workers = jobs
        self._pool: ProcessPoolExecutor | None = None
        self._before = set(multiprocessing.active_children())

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Begin a unit in one of the processes."""
        if self._pool is None:
            # Spawned, not forked: a copy of a process with threads may hang.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(
                self.workers, mp_context=context, initializer=_begin_worker
            )
        return self._pool.submit(carry_out, unit, contents)

    def renew(self) -> None:
        """Start other processes when the next unit comes."""
        self.close()

    def stop(self) -> None:
        """End the processes."""
        for process in set(multiprocessing.active_children()) - self._before:
            process.terminate()

    def close(self) -> None:
        """Wait until the processes have ended."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


class OnExecutor:
    """Workers of an executor that somebody else opened, and will close.

    Parameters
    ----------
    executor : Executor
        Its workers have the same gmfbo; they need share no files with this process.
    workers : int, optional
        Units that it does at once; found out where the executor says so.

    Raises
    ------
    InputError
        It does not say how many workers it has.
    """

    dies_whole = False

    def __init__(self, executor: Executor, workers: int | None = None) -> None:
        self._executor = executor
        self._count = _workers_of(executor) if workers is None else lambda: workers

    @property
    def workers(self) -> int:
        """Units that are done at once, as of now: workers may come and go."""
        return max(self._count(), 1)

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Begin a unit on some worker."""
        return self._executor.submit(carry_out, unit, contents)

    def renew(self) -> None:
        """Refuse: whoever opened the executor can open another one.

        Raises
        ------
        SimulationError
            Always.
        """
        raise SimulationError(
            f"the executor {type(self._executor).__name__} broke; what is finished is kept: give "
            "another one, and the same call goes on"
        )

    def stop(self) -> None:
        """Leave its workers to whoever opened it; nothing waits for them any more."""

    def close(self) -> None:
        """Leave the executor open."""


def _workers_of(executor: Any) -> Callable[[], int]:
    client = getattr(executor, "_client", None)  # of dask.distributed's Client.get_executor()
    if client is not None and hasattr(client, "nthreads"):
        return lambda: sum(client.nthreads().values())
    for name in ("num_workers", "_max_workers"):  # mpi4py.futures; the standard library
        count = getattr(executor, name, None)
        if isinstance(count, int):
            return lambda: count
    raise InputError(
        f"workers: expected a number, since {type(executor).__name__} does not say how many "
        "workers it has"
    )


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    sentinel = parent.sentinel

    def watch() -> None:
        wait_for_end([sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
