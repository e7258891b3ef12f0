"""The process that runs a twin's FMUs: `python -m gmfbo.sources.worker`, started by `isolation`.

Commands come as lines of JSON on standard input, answers go as lines of JSON to what was standard
output; arrays travel through a mapped file. The FMU's own standard output and error go to a log
file. It must start fast, so it loads neither pydantic nor SciPy nor torch.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any

import numpy as np

from gmfbo.errors import GmfboError
from gmfbo.sources.job import Job, Stage
from gmfbo.sources.shared_arrays import SharedArrays
from gmfbo.sources.simulator import Simulator
from gmfbo.sources.unpacked_fmu import UnpackedFmu

_PARENT_CHECK_S = 1.0
_LARGEST_LOG_BYTES = 2**20


class _Worker:
    """State between commands."""

    def __init__(self, commands: Callable[[], dict[str, Any]], answers: IO[str]) -> None:
        self._commands, self._answers = commands, answers
        self._mapped = ""
        self._arrays: SharedArrays | None = None

    def serve(self) -> None:
        """Load the FMUs, then run jobs until standard input ends."""
        first = self._commands()
        self._map(first)
        try:
            fmus = [UnpackedFmu(**fmu) for fmu in first["fmus"]]
            simulator = Simulator(fmus, mark=self._mark)
        except GmfboError as error:
            self._answer({"error": str(error)})
            return
        self._answer({"loaded": True})
        while True:
            command = self._commands()
            _shorten_log()
            self._map(command)
            assert self._arrays is not None
            job = Job.from_json(command["job"])
            outcome = simulator.run(job, *self._arrays.arrays(job.shapes))
            # Answered before the instances are freed, since some FMUs crash when freed.
            self._answer({**asdict(outcome), "memory": _resident_bytes()})
            simulator.free()

    def _map(self, command: Mapping[str, Any]) -> None:
        if command["arrays"] != self._mapped:
            self._mapped = command["arrays"]
            self._arrays = SharedArrays(Path(self._mapped))

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
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    with contextlib.suppress(BrokenPipeError):
        _Worker(_reader_of(commands, folder), answers).serve()
    os._exit(0)


def _prepare_process() -> None:
    # An interrupt from the keyboard goes to the whole group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a crash is expected, its dump is not
    np.seterr(all="ignore")


def _reader_of(commands: IO[str], folder: Path) -> Callable[[], dict[str, Any]]:
    """Read commands in a thread, which sees the parent's end even while an FMU hangs."""
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    parent = os.getppid()

    def read() -> None:
        for line in commands:
            lines.put(line)
        _leave(folder)

    def next_command() -> dict[str, Any]:
        while True:
            try:
                command: dict[str, Any] = json.loads(lines.get(timeout=_PARENT_CHECK_S))
            except queue.Empty:
                # A process forked from the parent may hold the pipe open after the parent's end.
                if os.getppid() != parent:
                    _leave(folder)
            else:
                return command

    threading.Thread(target=read, daemon=True).start()
    return next_command


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


if __name__ == "__main__":
    main()
