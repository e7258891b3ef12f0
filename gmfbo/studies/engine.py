"""Engines that run units: this process, processes of this machine, or any executor."""

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
    """Takes units, and gives futures of their results.

    Attributes
    ----------
    dies_whole : bool
        Whether a worker that dies takes all others with it.
    """

    dies_whole: bool

    @property
    def workers(self) -> int:
        """Number of units that run at once."""
        ...

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Start a unit, with contents that its worker may lack."""
        ...

    def renew(self) -> None:
        """Make the engine usable again after it broke."""
        ...

    def stop(self) -> None:
        """Abandon running units at once."""
        ...

    def close(self) -> None:
        """Close opened workers."""
        ...


class InProcess:
    """This process: a unit is run when it is submitted."""

    dies_whole = True
    workers = 1

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Run a unit."""
        future: Future[Result] = Future()
        future.set_result(carry_out(unit, contents))
        return future

    def renew(self) -> None:
        """Do nothing: this engine does not break."""

    def stop(self) -> None:
        """Do nothing: no unit is running."""

    def close(self) -> None:
        """Do nothing: no worker was opened."""


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
        """Start a unit in one of the processes."""
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
    """Workers of an executor that the caller opened, and will close.

    Parameters
    ----------
    executor : Executor
        Its workers have the same gmfbo, and need not share files with this process.
    workers : int, optional
        Number of units that run at once; asked of the executor unless given.

    Raises
    ------
    InputError
        It does not tell its number of workers.
    """

    dies_whole = False

    def __init__(self, executor: Executor, workers: int | None = None) -> None:
        self._executor = executor
        self._count = _workers_of(executor) if workers is None else lambda: workers

    @property
    def workers(self) -> int:
        """Number of units that run at once at present: workers may come and go."""
        return max(self._count(), 1)

    def submit(self, unit: Unit, contents: Mapping[str, bytes]) -> Future[Result]:
        """Start a unit on a worker."""
        return self._executor.submit(carry_out, unit, contents)

    def renew(self) -> None:
        """Raise, since only the caller can open another executor.

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
        """Leave its workers to the caller, without waiting for them."""

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
    """Leave Ctrl-C to the parent process, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    sentinel = parent.sentinel

    def watch() -> None:
        wait_for_end([sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
