"""The process that runs a twin's FMUs; `keeper` forks it, `worker_start` prepares it.

Commands come as lines of JSON on standard input, and answers go as lines of JSON to the original
standard output; arrays pass through a mapped file. The FMU's own standard output and error go to a
log file. The process must start fast, so it loads neither pydantic nor SciPy nor torch.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any

import numpy as np

from gmfbo.errors import GmfboError
from gmfbo.sources.fmu_file.job import Job, Stage
from gmfbo.sources.fmu_file.unpacked_fmu import UnpackedFmu
from gmfbo.sources.sandbox.limits import limit_processor_time
from gmfbo.sources.stepping.simulator import Simulator
from gmfbo.sources.worker.shared_arrays import SharedArrays

_LARGEST_LOG_BYTES = 2**20


class Worker:
    """State between commands.

    Parameters
    ----------
    first : mapping
        The first command: FMUs to load.
    commands, answers : text files
        Channels.
    work : Path
        Working folder.
    """

    def __init__(
        self, first: Mapping[str, Any], commands: IO[str], answers: IO[str], work: Path
    ) -> None:
        self._first, self._commands, self._answers = first, commands, answers
        self._work = work
        self._mapped = ""
        self._arrays: SharedArrays | None = None

    def serve(self, open_to_it: str) -> None:
        """Load the FMUs, then run jobs until standard input ends.

        Parameters
        ----------
        open_to_it : str
            Rights that the sandbox leaves open, for the first answer.
        """
        np.seterr(all="ignore")
        self._map(self._first)
        limit_processor_time(self._first["limit_s"])
        try:
            fmus = [UnpackedFmu(**fmu) for fmu in self._first["fmus"]]
            simulator = Simulator(fmus, mark=self._mark)
        except GmfboError as error:
            self._answer({"number": self._first["number"], "error": str(error)})
            return
        self._answer({"number": self._first["number"], "open": open_to_it})
        for line in self._commands:
            _shorten_log()
            self._run(simulator, json.loads(line))

    def _run(self, simulator: Simulator, command: Mapping[str, Any]) -> None:
        """Run jobs until one fails; they share the room of the arrays."""
        arrays = self._map(command)
        limit_processor_time(command["limit_s"])
        jobs = [Job.from_json(raw) for raw in command["jobs"]]
        tables = iter(arrays.arrays(tuple(shape for job in jobs for shape in job.shapes)))
        outcomes = []
        for job in jobs:
            outcomes.append(simulator.run(job, next(tables), next(tables), next(tables)))
            if outcomes[-1].status != "ok":
                break
        # Answer before the last instances are freed, since some FMUs crash when freed.
        answer = [asdict(outcome) for outcome in outcomes]
        self._mark(Stage.ANSWER, 0)
        self._answer({"number": command["number"], "outcomes": answer, "memory": _resident_bytes()})
        simulator.free()
        os.chdir(self._work)  # some FMUs change it

    def _map(self, command: Mapping[str, Any]) -> SharedArrays:
        if self._arrays is None or command["arrays"] != self._mapped:
            self._mapped = command["arrays"]
            self._arrays = SharedArrays(Path(self._mapped))
        return self._arrays

    def _mark(self, stage: Stage, fmu: int) -> None:
        if self._arrays is not None:
            self._arrays.progress[:] = (stage, fmu)

    def _answer(self, answer: Mapping[str, Any]) -> None:
        self._answers.write(json.dumps(answer) + "\n")
        self._answers.flush()


def _shorten_log() -> None:
    with contextlib.suppress(OSError):
        if os.fstat(2).st_size > _LARGEST_LOG_BYTES:
            os.ftruncate(2, 0)


def _resident_bytes() -> int:
    """Memory in use, or 0 where the system does not tell."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        pages = int(Path("/proc/self/statm").read_bytes().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")
    return 0
