"""Run loaded FMUs in this process; used by the worker and by the in-process mode."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gmfbo.sources.fmu_file.job import STOP_TIME_LINE, Job, Outcome, Stage
from gmfbo.sources.fmu_file.unpacked_fmu import UnpackedFmu
from gmfbo.sources.stepping.fmi2 import FmuCallError, Instance, LoadedFmu
from gmfbo.sources.stepping.master import step_all
from gmfbo.sources.stepping.stop import LoopStage, Stop

Mark = Callable[[Stage, int], None]
_DISCARD = 2
_STOP_TIME = re.compile(r"(stop|end|final)[ _]?time", re.IGNORECASE)
_CALLS = {
    LoopStage.SET: "setting its inputs",
    LoopStage.GET: "reading its outputs",
}
_DEMANDS = {
    LoopStage.EVENT: (
        "asks for event mode before {}: gmfbo steps at fixed communication points, without event "
        "mode; ask its vendor for an export that handles its events itself"
    ),
    LoopStage.ENDED: "ended the simulation before {}",
}


def ignore_mark(stage: Stage, fmu: int) -> None:
    """Ignore progress, which only a surviving parent process could report."""


class Simulator:
    """FMUs of one twin, loaded; each run gets new instances.

    A new instance costs 0.01-0.2 ms, and `fmi2Reset` silently failed to restore the start state
    in 13 of 84 third-party FMUs.

    Parameters
    ----------
    fmus : sequence of UnpackedFmu
        In order of computation.
    mark : callable
        Called with the stage and FMU before each request, so that a crash can be explained.
    native : bool
        Step by the C master where there is one.

    Raises
    ------
    FmuFileError
        A library cannot be loaded.
    """

    def __init__(
        self, fmus: Sequence[UnpackedFmu], *, mark: Mark = ignore_mark, native: bool = True
    ) -> None:
        self._mark, self._native = mark, native
        self._instances: list[Instance] = []
        self._fmus: list[LoadedFmu] = []
        for index, fmu in enumerate(fmus):
            mark(Stage.LOAD, index)
            self._fmus.append(_load(fmu))
        mark(Stage.IDLE, 0)

    def run(
        self, job: Job, u: NDArray[np.float64], s: NDArray[np.float64], y: NDArray[np.float64]
    ) -> Outcome:
        """Simulate once; the instances live on until `free`.

        Parameters
        ----------
        job : Job
            The run.
        u, s : ndarray, shape (steps, n)
            Inputs and scheduled parameters.
        y : ndarray, shape (steps + 1, n)
            Filled with outputs.
        """
        self.free()
        try:
            for index, fmu in enumerate(self._fmus):
                self._mark(Stage.INSTANTIATE, index)
                self._instances.append(fmu.instantiate())
            for index, instance in enumerate(self._instances):
                self._mark(Stage.INITIALISE, index)
                own = [setting for setting in job.settings if setting.fmu == index]
                texts = [text for text in job.texts if text.fmu == index]
                instance.initialise(job.start, own, texts, job.stop)
        except FmuCallError as error:
            message = f"{error} while it was {error.stage.words}"
            if job.stop is None and _STOP_TIME.search(message):
                message += f"; put '{STOP_TIME_LINE}' above the tables of the twin file"
            return Outcome("failed", 0, message, stage=error.stage)
        self._mark(Stage.STEP, 0)
        stop = step_all(self._instances, job, u, s, y, native=self._native)
        return self._outcome(job, stop)

    def free(self) -> None:
        """Free the instances of the last run."""
        for index, instance in enumerate(self._instances):
            self._mark(Stage.FREE, index)
            instance.free()
        self._instances.clear()
        self._mark(Stage.IDLE, 0)

    def _outcome(self, job: Job, stop: Stop) -> Outcome:
        if not stop.stopped:
            return Outcome("ok", job.steps + 1, warnings=stop.warnings)
        fmu, stage, rows = self._fmus[stop.fmu], LoopStage(stop.stage), stop.step + 1
        time = job.told_time(max(stop.step, 0))
        if stage == LoopStage.NOT_FINITE:
            after = job.told_time(rows)
            message = (
                f"'{fmu.name}' diverged: an output is not finite at t = {after:g} s; the gains or "
                "parameters make it unstable, or its own step is too long"
            )
            return Outcome("diverged", rows, message, stop.warnings)
        if stage in _DEMANDS:
            message = f"'{fmu.name}' {_DEMANDS[stage].format(f't = {time + job.step:g} s')}"
        else:
            call = _CALLS.get(stage, fmu.interface.do_step)
            message = f"{fmu.refusal(call, stop.fmi_status)} at t = {time:g} s"
        if stop.fmi_status == _DISCARD and self._instances[stop.fmu].has_ended():
            message += ": it ended the simulation itself; check its limits and end conditions"
        return Outcome("failed", rows, message, stop.warnings)


def _load(fmu: UnpackedFmu) -> LoadedFmu:
    if fmu.fmi == 2:
        return LoadedFmu(fmu)
    from gmfbo.sources.stepping.fmi3 import LoadedFmu3

    return LoadedFmu3(fmu)
