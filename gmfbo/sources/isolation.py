"""Runs of a twin in a process of its own, which may crash, exit or hang."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import FmuFileError
from gmfbo.sources.binding import Binding
from gmfbo.sources.job import Job, Outcome, Stage
from gmfbo.sources.post_mortem import crash_message, timeout_message
from gmfbo.sources.private_folder import PrivateFolder
from gmfbo.sources.runner import once_only, unpack_fmus
from gmfbo.sources.shared_arrays import SharedArrays, reserve
from gmfbo.sources.worker_process import WorkerDied, WorkerProcess, WorkerTimeout

START_LIMIT_S = 60.0
"""[s] For a worker to start and load the libraries; a cold disk is slow."""

_GROWTH_BYTES = 256 * 2**20
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

    def run(
        self, job: Job, u: NDArray[np.float64], s: NDArray[np.float64]
    ) -> tuple[Outcome, NDArray[np.float64]]:
        """Simulate once; outputs of shape (steps + 1, n_outputs), valid up to the outcome's rows.

        Parameters
        ----------
        job : Job
            What is set, stepped and read.
        u, s : ndarray, shape (steps, n)
            Inputs and scheduled parameters.

        Raises
        ------
        FmuFileError
            A library cannot be loaded.
        SimulationError
            The disk has no room for the run.
        """
        if not self._belongings.folder.is_mine:
            self._begin()  # a forked copy must not talk to its parent's worker
        try:
            outcome, outputs = self._run_once(job, u, s)
            if outcome is None:
                # The worker fell after the last answer, while it freed instances or waited.
                outcome, outputs = self._run_once(job, u, s)
        except BaseException:
            self._drop_worker()  # the answer under way is nobody's
            raise
        if self._once_only:
            self._drop_worker()
        return outcome or self._crashed(job, outputs, -9), outputs

    def close(self) -> None:
        """End the worker and remove its files."""
        self._finalizer()

    def _begin(self) -> None:
        self._belongings = _Belongings(PrivateFolder())
        self._finalizer = weakref.finalize(self, self._belongings.give_back)
        self._arrays: SharedArrays | None = None
        self._arrays_path = ""
        self._first_memory = 0
        try:
            self._fmus = unpack_fmus(self._binding, self._belongings.folder.path)
        except BaseException:
            self.close()
            raise

    def _run_once(
        self, job: Job, u: NDArray[np.float64], s: NDArray[np.float64]
    ) -> tuple[Outcome | None, NDArray[np.float64]]:
        """Run on the present worker; no outcome where it was gone before the run began."""
        arrays = self._room_for(job)
        shared_u, shared_s, shared_y = arrays.arrays(job.shapes)
        shared_u[:], shared_s[:], shared_y[:] = u, s, np.nan
        try:
            worker = self._worker()
            answer = worker.ask({"arrays": self._arrays_path, "job": vars(job)}, self._time_limit_s)
        except WorkerTimeout:
            outcome = self._timed_out(job, shared_y)
        except WorkerDied as death:
            outcome = self._crashed(job, shared_y, death.exit_code)
            if self._stage() in _BEFORE_THE_RUN:
                self._drop_worker()
                return None, shared_y.copy()
        else:
            self._replace_if_grown(answer.pop("memory"))
            return Outcome(**answer), shared_y.copy()
        self._drop_worker()
        return outcome, shared_y.copy()

    def _worker(self) -> WorkerProcess:
        """Return the present worker, or a fresh one that has loaded the FMUs."""
        if self._belongings.worker is None:
            assert self._arrays is not None
            self._arrays.progress[:] = (Stage.LOAD, 0)
            worker = self._belongings.worker = WorkerProcess(self._belongings.folder.path)
            self._first_memory = 0
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
        # Some vendors' FMUs leak 200 kB an instance.
        self._first_memory = self._first_memory or memory
        if memory > self._first_memory + _GROWTH_BYTES:
            self._drop_worker()

    def _room_for(self, job: Job) -> SharedArrays:
        doubles = sum(rows * columns for rows, columns in job.shapes)
        if self._arrays is None or self._arrays.room < doubles:
            folder = self._belongings.folder.path
            path = folder / f"arrays{doubles}"
            reserve(path, max(doubles, _LEAST_ROOM))
            if self._arrays is not None:
                Path(
                    self._arrays_path
                ).unlink()  # the worker keeps its mapping until the next command
            self._arrays, self._arrays_path = SharedArrays(path), str(path)
            self._first_memory = 0
        return self._arrays

    def _stage(self) -> Stage:
        assert self._arrays is not None
        return Stage(int(self._arrays.progress[0]))

    def _crashed(self, job: Job, outputs: NDArray[np.float64], exit_code: int) -> Outcome:
        rows, circumstances = self._circumstances(job, outputs)
        return Outcome("crashed", rows, crash_message(exit_code=exit_code, **circumstances))

    def _timed_out(self, job: Job, outputs: NDArray[np.float64]) -> Outcome:
        rows, circumstances = self._circumstances(job, outputs)
        limit = START_LIMIT_S if self._stage() == Stage.LOAD else self._time_limit_s
        return Outcome("timeout", rows, timeout_message(limit_s=limit, **circumstances))

    def _circumstances(self, job: Job, outputs: NDArray[np.float64]) -> tuple[int, dict[str, Any]]:
        """Count the rows that were filled, and say where the worker stood."""
        assert self._arrays is not None
        blank = np.isnan(outputs).any(axis=1)
        rows = int(np.argmax(blank)) if blank.any() else len(outputs)
        worker = self._belongings.worker
        return rows, {
            "names": self._names,
            "stage": self._stage(),
            "fmu": int(self._arrays.progress[1]),
            "time": job.start + (rows - 1) * job.step if rows else None,
            "said": worker.last_words() if worker else "",
        }
