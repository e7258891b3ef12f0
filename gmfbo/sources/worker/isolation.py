"""Run a twin's FMUs in a process of its own, which may crash, exit or hang."""

from __future__ import annotations

import sys
import warnings
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import FmuFileError, SimulationError
from gmfbo.files.private_folder import PrivateFolder
from gmfbo.sources.binding.binding import Binding
from gmfbo.sources.fmu_file.job import Outcome, Stage
from gmfbo.sources.sandbox.policy import Policy, way_out
from gmfbo.sources.worker.answer import filled_rows, read_outcomes
from gmfbo.sources.worker.post_mortem import (
    WhereItStood,
    crash_message,
    garbled_message,
    plain_line,
    timeout_message,
)
from gmfbo.sources.worker.runner import Order, Result, once_only, unpack_fmus
from gmfbo.sources.worker.shared_arrays import SharedArrays, reserve
from gmfbo.sources.worker.worker_process import (
    WorkerDied,
    WorkerGarbled,
    WorkerProcess,
    WorkerTimeout,
)

START_LIMIT_S = 60.0
"""[s] Time for a worker to start and load the libraries; a cold disk is slow."""

LEAST_LIMIT_S, LIMIT_PER_SIMULATED_S = 10.0, 20.0
"""[s], [1] Time of a run: a slow FMU runs in real time, and is given 20 times that."""

_WARM_UP_ANSWERS = 20
_WARM_UP_BYTES = 256 * 2**20  # an FMU may fill its caches first; later growth is a leak
_GROWTH_BYTES = 12 * 2**20
_LEAST_ROOM = 2**15
_told = False
_BETWEEN_RUNS = (Stage.IDLE, Stage.FREE)
_MOST_IN_VAIN = 2
_MADE_AGAIN = {
    ("crashed", Stage.INSTANTIATE),
    ("timeout", Stage.INSTANTIATE),
    ("failed", Stage.INSTANTIATE),
    ("crashed", Stage.INITIALISE),
}
"""Outcomes of an FMU that supports one instance a process without stating it."""


@dataclass
class _Belongings:
    """Worker, folder and memory of a runner, released also when it is garbage collected."""

    folder: PrivateFolder
    worker: WorkerProcess | None = None

    def give_back(self) -> None:
        worker, self.worker = self.worker, None
        if worker is not None and self.folder.is_mine:
            worker.end()
        self.folder.remove()


class Isolated:
    """Runs jobs in a worker process; a dead or leaking worker is replaced.

    Parameters
    ----------
    binding : Binding
        The twin.
    time_limit_s : float or None
        [s] Wall-clock time of one run; None for 10 s and 20 times its simulated time.

    Raises
    ------
    FmuFileError
        An FMU cannot be unpacked.
    InputError
        GMFBO_SANDBOX is invalid.
    """

    def __init__(self, binding: Binding, *, time_limit_s: float | None) -> None:
        self._binding, self._time_limit_s = binding, time_limit_s
        self._names = [fmu.path.name for fmu in binding.fmus]
        self._once_only = bool(once_only(binding))
        self._policy = Policy.from_environment()
        self._warned: set[str] = set()
        self._begin()

    def run(self, *orders: Order) -> list[Result]:
        """Simulate each order on new instances, up to the first that does not end well.

        Parameters
        ----------
        *orders : Order
            Jobs with their arrays. If a worker dies, the order that it was running has failed.

        Raises
        ------
        FmuFileError
            A library cannot be loaded.
        SimulationError
            The disk has no room for the runs.
        """
        if not self._belongings.folder.is_mine:
            self._begin()  # a forked copy must not talk to its parent's worker
        if self._once_only:
            return self._run_apart(orders)
        used = self._belongings.worker is not None and self._answers > 0
        results = self._run_together(orders)
        outcome = results[-1].outcome
        if (used or len(results) > 1) and (outcome.status, outcome.stage) in _MADE_AGAIN:
            results[-1:] = self._run_anew(orders[len(results) - 1 :])
        return results

    def close(self) -> None:
        """End the worker and remove its files."""
        self._finalizer()

    def _begin(self) -> None:
        self._belongings = _Belongings(PrivateFolder())
        self._finalizer = weakref.finalize(self, self._belongings.give_back)
        self._arrays: SharedArrays | None = None
        self._arrays_path = ""
        self._first_memory = self._answers = 0
        folder = self._belongings.folder.path
        self._work, self._shared = folder / "work", folder / "shared"
        try:
            self._work.mkdir()
            self._shared.mkdir()
            self._fmus = unpack_fmus(self._binding, folder)
        except BaseException:
            self.close()
            raise

    def _run_apart(self, orders: Sequence[Order]) -> list[Result]:
        """Run each order in a process of its own, up to the first that does not end well."""
        results: list[Result] = []
        for order in orders:
            results += self._run_together([order])
            self._drop_worker()
            if results[-1].outcome.status != "ok":
                break
        return results

    def _run_anew(self, orders: Sequence[Order]) -> list[Result]:
        """Run orders again after the first one crashed in a process with earlier instances."""
        self._drop_worker()
        results = self._run_apart(orders)
        outcome = results[0].outcome
        if (outcome.status, outcome.stage) not in _MADE_AGAIN:
            self._once_only = True
            self._warn(
                "bears one instance in the life of a process, though it does not say so: each run "
                "gets a process of its own from now on"
            )
        return results

    def _warn(self, what: str) -> None:
        if what in self._warned:
            return
        self._warned.add(what)
        names = ", ".join(f"'{name}'" for name in self._names)
        warnings.warn(f"{names} {what}", RuntimeWarning, stacklevel=2)

    def _run_together(self, orders: Sequence[Order]) -> list[Result]:
        results: list[Result] = []
        in_vain = 0
        try:
            # A worker may crash after its last answer, or between two runs while it frees
            # instances: then the next worker goes on.
            while len(results) < len(orders) and in_vain < _MOST_IN_VAIN:
                got = self._ask(orders[len(results) :])
                results += got
                in_vain = 0 if got else in_vain + 1
                if got and got[-1].outcome.status != "ok":
                    break
        except BaseException:
            self._drop_worker()  # nobody will read the pending answer
            raise
        if in_vain:
            raise SimulationError(
                f"the worker process of {', '.join(self._names)} is killed again and again "
                "before it begins; check the limits on memory and processes"
            )
        return results

    def _ask(self, orders: Sequence[Order]) -> list[Result]:
        """Run on the present worker; returns fewer results where it crashed between two runs."""
        shapes = tuple(shape for order in orders for shape in order.job.shapes)
        arrays = self._room_for(sum(rows * columns for rows, columns in shapes))
        tables = arrays.arrays(shapes)
        for order, u, s, y in zip(orders, tables[::3], tables[1::3], tables[2::3], strict=True):
            u[:], s[:], y[:] = order.u, order.s, np.nan
        command = {"arrays": self._arrays_path, "jobs": [vars(order.job) for order in orders]}
        outputs = tables[2::3]
        try:
            answer = self._worker().ask(command, self._limit(orders))
        except WorkerTimeout:
            outcomes = self._lost(orders, outputs, None)
        except WorkerGarbled:
            outcomes = self._garbled()
        except WorkerDied as death:
            outcomes = self._lost(orders, outputs, death.exit_code)
        else:
            outcomes = read_outcomes(answer, outputs) or self._garbled()
            outcomes = [self._with_way_out(outcome) for outcome in outcomes]
            self._replace_if_grown(answer.get("memory"))
        return [Result(outcome, y.copy()) for outcome, y in zip(outcomes, outputs, strict=False)]

    def _worker(self) -> WorkerProcess:
        if self._belongings.worker is None:
            assert self._arrays is not None
            self._arrays.progress[:] = (Stage.LOAD, 0)
            worker = self._belongings.worker = WorkerProcess(self._belongings.folder.path)
            self._answers = 0
            first = {
                "arrays": self._arrays_path,
                "fmus": [vars(fmu) for fmu in self._fmus],
                "work": str(self._work),
                "policy": self._policy.as_dict(),
            }
            answer = worker.ask(first, START_LIMIT_S)
            if "error" in answer:
                raise FmuFileError(plain_line(answer["error"]))
            self._tell_what_is_open(plain_line(answer.get("open", "")))
        return self._belongings.worker

    def _tell_what_is_open(self, what: str) -> None:
        """Warn of an incomplete sandbox, once a process."""
        global _told
        if what and not _told and self._policy.enclosed and sys.platform == "linux":
            _told = True
            self._warn(f"runs without the whole sandbox: {what}; run FMUs that you trust")

    def _drop_worker(self) -> None:
        worker, self._belongings.worker = self._belongings.worker, None
        if worker is not None:
            worker.kill()

    def _replace_if_grown(self, memory: object) -> None:
        # Exports of OpenModelica leak 3 kB an instance, some vendors' FMUs 200 kB.
        self._answers += 1
        if not isinstance(memory, int):
            return
        warm = self._answers > _WARM_UP_ANSWERS
        limit = _GROWTH_BYTES if warm else _WARM_UP_BYTES
        if self._answers in (1, _WARM_UP_ANSWERS):
            self._first_memory = memory
        if memory > self._first_memory + limit:
            self._drop_worker()

    def _room_for(self, doubles: int) -> SharedArrays:
        if self._arrays is None or self._arrays.room < doubles:
            path = self._shared / f"arrays{doubles}"
            reserve(path, max(doubles, _LEAST_ROOM))
            if self._arrays is not None:
                # The worker keeps its mapping until the next command.
                Path(self._arrays_path).unlink()
            self._arrays, self._arrays_path = SharedArrays(path), str(path)
            self._answers = 0
        return self._arrays

    def _lost(
        self,
        orders: Sequence[Order],
        outputs: Sequence[NDArray[np.float64]],
        exit_code: int | None,
    ) -> list[Outcome]:
        """Outcome of each order after the worker died or, without an exit code, hung."""
        stage, fmu = self._stage(), self._fmu()
        filled = [filled_rows(y) for y in outputs]
        if stage == Stage.ANSWER and not any(filled):
            stage = Stage.IDLE  # the worker had answered, and begun nothing since
        if stage == Stage.FREE and not self._once_only:
            self._once_only = True
            self._warn("falls when it is freed: each run gets a process of its own from now on")
        worker = self._belongings.worker
        said = worker.last_words() if worker else ""
        self._drop_worker()
        held = worker.peak_memory() if worker else 0
        versions = [fmu.fmi for fmu in self._fmus]
        outcomes = []
        for order, y, rows in zip(orders, outputs, filled, strict=True):
            complete = stage in (Stage.ANSWER, *_BETWEEN_RUNS)
            if rows == len(y) and (order is not orders[-1] or complete):
                outcomes.append(Outcome("ok", rows))
                continue
            if stage in _BETWEEN_RUNS:
                break
            time = order.job.told_time(rows - 1) if rows else None
            where = WhereItStood(self._names, stage, fmu, time, said, self._policy, held, versions)
            if exit_code is None:
                limit = START_LIMIT_S if stage == Stage.LOAD else self._limit(orders)
                outcomes.append(Outcome("timeout", rows, timeout_message(where, limit), 0, stage))
            else:
                message = crash_message(where, exit_code)
                outcomes.append(Outcome("crashed", rows, message, 0, stage))
            break
        if stage == Stage.ANSWER:
            self._warn("closes files of the process that it runs in: each run gets a fresh one")
        return outcomes

    def _with_way_out(self, outcome: Outcome) -> Outcome:
        """The outcome; its message names the sandbox where that may have refused something."""
        if outcome.status != "failed" or sys.platform != "linux":
            return outcome
        return replace(outcome, message=outcome.message + way_out(self._policy, outcome.message))

    def _limit(self, orders: Sequence[Order]) -> float:
        """[s] Wall-clock time in which a worker has to answer."""
        if self._time_limit_s is not None:
            return self._time_limit_s
        simulated = sum(order.job.duration for order in orders)
        return LEAST_LIMIT_S + LIMIT_PER_SIMULATED_S * simulated

    def _garbled(self) -> list[Outcome]:
        self._drop_worker()
        return [Outcome("crashed", 0, garbled_message(self._names))]

    def _stage(self) -> Stage:
        assert self._arrays is not None
        try:
            return Stage(int(self._arrays.progress[0]))
        except ValueError:  # foreign code can overwrite the header
            return Stage.STEP

    def _fmu(self) -> int:
        assert self._arrays is not None
        fmu = int(self._arrays.progress[1])
        return fmu if 0 <= fmu < len(self._names) else 0
