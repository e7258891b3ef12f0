"""Runs on several processes; what ends one run does not end the others."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait as wait_for_end

from gmfbo.errors import GmfboError
from gmfbo.studies.one_run import OneRun
from gmfbo.studies.outcome import Outcome

Finished = Callable[[OneRun, Outcome | str], None]


def run_all(runs: Sequence[OneRun], jobs: int, finished: Finished) -> None:
    """Make runs, in order, so many at a time.

    Parameters
    ----------
    runs : sequence of OneRun
        To be made.
    jobs : int
        Processes; with one, everything happens in this process.
    finished : callable
        Told of each run: what it came to, or in a line why it failed.
    """
    if jobs == 1:
        for run in runs:
            finished(run, _attempt(run))
        return
    waiting = iter(runs)
    while True:
        lost = _run_in_pool(waiting, jobs, finished)
        # A process that the system killed takes the pool with it; what it was at is made here
        # one by one, so that the run which did it is known.
        for run in lost:
            finished(run, _alone(run))
        if not lost:
            return


def _run_in_pool(waiting: Iterator[OneRun], jobs: int, finished: Finished) -> list[OneRun]:
    """Make runs until none is left or a process dies; returns those that were lost with it."""
    before = set(multiprocessing.active_children())
    pool = _pool(jobs)
    under_way: dict[Future[Outcome | str], OneRun] = {}
    lost: list[OneRun] = []
    try:
        # No more is handed in than runs at once: what waits inside a pool cannot be called back.
        while not lost:
            while not lost and len(under_way) < jobs:
                if (run := next(waiting, None)) is None:
                    break
                try:
                    under_way[pool.submit(_attempt, run)] = run
                except BrokenProcessPool:
                    lost.append(run)
            if not under_way:
                break
            for done in wait(under_way, return_when=FIRST_COMPLETED).done:
                run = under_way.pop(done)
                try:
                    finished(run, done.result())
                except BrokenProcessPool:
                    lost.append(run)
        lost += under_way.values()
    except BaseException:
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return lost


def _alone(run: OneRun) -> Outcome | str:
    with _pool(1) as pool:
        try:
            return pool.submit(_attempt, run).result()
        except BrokenProcessPool:
            return "its process was ended from outside; is the memory used up?"


def _pool(jobs: int) -> ProcessPoolExecutor:
    # Spawned, not forked: a copy of a process with threads may hang.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin_worker)


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


def _attempt(run: OneRun) -> Outcome | str:
    try:
        return run.run()
    except GmfboError as error:
        return " ".join(str(error).split())
    except Exception as error:
        # A method is foreign code too: its fault costs this run, and is named.
        return " ".join(f"{error!r}".split())
