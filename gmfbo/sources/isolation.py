"""Runs of a twin in a process of its own, which may crash, exit or hang."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import FmuFileError, SimulationError
from gmfbo.sources.binding import Binding
from gmfbo.sources.job import Outcome, Stage
from gmfbo.sources.post_mortem import WhereItStood, crash_message, timeout_message
from gmfbo.sources.private_folder import PrivateFolder
from gmfbo.sources.runner import Order, Result, once_only, unpack_fmus
from gmfbo.sources.shared_arrays import SharedArrays, reserve
from gmfbo.sources.worker_process import WorkerDied, WorkerProcess, WorkerTimeout

START_LIMIT_S = 60.0
"""[s] For a worker to start and load the libraries; a cold disk is slow."""

_WARM_UP_ANSWERS = 20
_WARM_UP_BYTES = 256 * 2**20  # an FMU may fill its caches first; what grows later leaks
_GROWTH_BYTES = 12 * 2**20
_LEAST_ROOM = 2**15
_BEFORE_THE_RUN = (Stage.IDLE, Stage.FREE)


@dataclass
class _Belongings:
    """What has to be given back, also when the runner is merely forgotten."""

    folder: PrivateFolder
    worker: WorkerProcess | None = None

    def give_back(self) -> None:
        worker, self.worker = self.worker, None
        if worker is not None and self.folder.is_mine:
            worker.end()
        self.folder.remove()


class Isolated:
    """Runs jobs in a worker process; a worker that died or grew is replaced.

    Parameters
    ----------
    binding : Binding
        The twin.
    time_limit_s : float
        [s] Wall-clock time of one run.

    Raises
    ------
    FmuFileError
        An FMU cannot be unpacked.
    """

    def __init__(self, binding: Binding, *, time_limit_s: float) -> None:
        self._binding, self._time_limit_s = binding, time_limit_s
        self._names = [fmu.path.name for fmu in binding.fmus]
        self._once_only = bool(once_only(binding))
        self._begin()

    def run(self, *orders: Order) -> list[Result]:
        """Simulate each order on new instances, up to the first that does not end well.

        Parameters
        ----------
        *orders : Order
            What is set, stepped and read. A worker that dies ends the last one it began.

        Raises
        ------
        FmuFileError
            A library cannot be loaded.
        SimulationError
            The disk has no room for the runs.
        """
        if not self._belongings.folder.is_mine:
            self._begin()  # a forked copy must not talk to its parent's worker
        if not self._once_only:
            return self._run_together(orders)
        results: list[Result] = []
        for order in orders:
            results += self._run_together([order])
            self._drop_worker()
            if results[-1].outcome.status != "ok":
                break
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
        try:
            self._fmus = unpack_fmus(self._binding, self._belongings.folder.path)
        except BaseException:
            self.close()
            raise

    def _run_together(self, orders: Sequence[Order]) -> list[Result]:
        try:
            results = self._ask(orders)
            if results is None:
                # The worker fell after the last answer, while it freed instances or waited.
                results = self._ask(orders)
        except BaseException:
            self._drop_worker()  # the answer under way is nobody's
            raise
        if results is None:
            raise SimulationError(
                f"the worker process of {', '.join(self._names)} is killed again and again "
                "before it begins; check the limits on memory and processes"
            )
        return results

    def _ask(self, orders: Sequence[Order]) -> list[Result] | None:
        """Run on the present worker; None where it was gone before the run began."""
        shapes = tuple(shape for order in orders for shape in order.job.shapes)
        arrays = self._room_for(sum(rows * columns for rows, columns in shapes))
        tables = arrays.arrays(shapes)
        for order, u, s, y in zip(orders, tables[::3], tables[1::3], tables[2::3], strict=True):
            u[:], s[:], y[:] = order.u, order.s, np.nan
        command = {"arrays": self._arrays_path, "jobs": [vars(order.job) for order in orders]}
        outputs = tables[2::3]
        try:
            answer = self._worker().ask(command, self._time_limit_s)
        except WorkerTimeout:
            outcomes = self._lost(orders, outputs, None)
        except WorkerDied as death:
            if self._stage() in _BEFORE_THE_RUN:
                self._drop_worker()
                return None
            outcomes = self._lost(orders, outputs, death.exit_code)
        else:
            self._replace_if_grown(answer["memory"])
            outcomes = [Outcome(**outcome) for outcome in answer["outcomes"]]
        return [Result(outcome, y.copy()) for outcome, y in zip(outcomes, outputs, strict=False)]

    def _worker(self) -> WorkerProcess:
        """Return the present worker, or a fresh one that has loaded the FMUs."""
        if self._belongings.worker is None:
            assert self._arrays is not None
            self._arrays.progress[:] = (Stage.LOAD, 0)
            worker = self._belongings.worker = WorkerProcess(self._belongings.folder.path)
            self._answers = 0
            fmus = [vars(fmu) for fmu in self._fmus]
            answer = worker.ask({"arrays": self._arrays_path, "fmus": fmus}, START_LIMIT_S)
            if "error" in answer:
                raise FmuFileError(answer["error"])
        return self._belongings.worker

    def _drop_worker(self) -> None:
        worker, self._belongings.worker = self._belongings.worker, None
        if worker is not None:
            worker.kill()

    def _replace_if_grown(self, memory: int) -> None:
        # Exports of OpenModelica leak 3 kB an instance, some vendors' FMUs 200 kB.
        self._answers += 1
        warm = self._answers > _WARM_UP_ANSWERS
        limit = _GROWTH_BYTES if warm else _WARM_UP_BYTES
        if self._answers in (1, _WARM_UP_ANSWERS):
            self._first_memory = memory
        if memory > self._first_memory + limit:
            self._drop_worker()

    def _room_for(self, doubles: int) -> SharedArrays:
        if self._arrays is None or self._arrays.room < doubles:
            path = self._belongings.folder.path / f"arrays{doubles}"
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
        """What became of each order when the worker died, or without exit code, hung."""
        stage, fmu = self._stage(), self._fmu()
        said = self._belongings.worker.last_words() if self._belongings.worker else ""
        self._drop_worker()
        outcomes = []
        for order, y in zip(orders, outputs, strict=True):
            rows = _filled_rows(y)
            if rows == len(y) and order is not orders[-1]:
                outcomes.append(Outcome("ok", rows))
                continue
            time = order.job.start + (rows - 1) * order.job.step if rows else None
            where = WhereItStood(self._names, stage, fmu, time, said)
            if exit_code is None:
                limit = START_LIMIT_S if stage == Stage.LOAD else self._time_limit_s
                outcomes.append(Outcome("timeout", rows, timeout_message(where, limit)))
            else:
                outcomes.append(Outcome("crashed", rows, crash_message(where, exit_code)))
            break
        return outcomes

    def _stage(self) -> Stage:
        assert self._arrays is not None
        return Stage(int(self._arrays.progress[0]))

    def _fmu(self) -> int:
        assert self._arrays is not None
        return int(self._arrays.progress[1])


def _filled_rows(y: NDArray[np.float64]) -> int:
    """Leading rows without NaN: outputs are NaN until they are written."""
    blank = np.isnan(y).any(axis=1)
    return int(np.argmax(blank)) if blank.any() else len(y)
