"""The process that runs a twin's FMUs; `worker_process` starts it.

Commands come as lines of JSON on standard input, answers go as lines of JSON to what was standard
output; arrays travel through a mapped file. The FMU's own standard output and error go to a log
file. It must start fast, so it loads neither pydantic nor SciPy nor torch.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import sys
from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from gmfbo.errors import GmfboError
from gmfbo.sources.job import Job, Stage
from gmfbo.sources.parent_watch import when_parent_is_gone
from gmfbo.sources.shared_arrays import SharedArrays
from gmfbo.sources.simulator import Simulator
from gmfbo.sources.unpacked_fmu import UnpackedFmu

_LARGEST_LOG_BYTES = 2**20


class _Worker:
    """State between commands."""

    def __init__(self, commands: IO[str], answers: IO[str]) -> None:
        self._commands, self._answers = commands, answers
        self._mapped = ""
        self._arrays: SharedArrays | None = None

    def serve(self) -> None:
        """Load the FMUs, then run jobs until standard input ends."""
        first = json.loads(self._commands.readline() or "null")
        if first is None:
            return
        self._map(first)
        try:
            fmus = [UnpackedFmu(**fmu) for fmu in first["fmus"]]
            simulator = Simulator(fmus, mark=self._mark)
        except GmfboError as error:
            self._answer({"error": str(error)})
            return
        self._answer({"loaded": True})
        for line in self._commands:
            _shorten_log()
            self._run(simulator, json.loads(line))

    def _run(self, simulator: Simulator, command: Mapping[str, Any]) -> None:
        """Run jobs until one does not end well; they share the room of the arrays."""
        arrays = self._map(command)
        jobs = [Job.from_json(raw) for raw in command["jobs"]]
        tables = iter(arrays.arrays(tuple(shape for job in jobs for shape in job.shapes)))
        outcomes = []
        for job in jobs:
            outcomes.append(simulator.run(job, next(tables), next(tables), next(tables)))
            if outcomes[-1].status != "ok":
                break
        # Answered before the last instances are freed, since some FMUs crash when freed.
        answer = [asdict(outcome) for outcome in outcomes]
        self._answer({"outcomes": answer, "memory": _resident_bytes()})
        simulator.free()

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


def main() -> None:
    """Serve the process that started this one until it closes standard input or is gone."""
    folder = Path(sys.argv[1])
    _prepare_process()
    # What the FMU prints must not get between the answers.
    commands = os.fdopen(os.dup(0), "r", encoding="utf-8")
    when_parent_is_gone(commands.fileno(), partial(_leave, folder))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    with contextlib.suppress(BrokenPipeError):
        _Worker(commands, answers).serve()
    _leave(folder)


def _prepare_process() -> None:
    # An interrupt from the keyboard goes to the whole group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a crash is expected, its dump is not
    np.seterr(all="ignore")


def _leave(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)  # past the FMU's own clean-up, which may hang


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
