"""A worker from its parent's side: started, asked, ended."""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from gmfbo.sources.worker.keeper import PEAK_MEMORY

_PACKAGE_PARENT = Path(__file__).resolve().parents[3]
# -P keeps modules of the user's working folder from shadowing ours; the parent's copy of this
# package is found even where it is not installed.
_START = (
    f"import sys; sys.path.append({str(_PACKAGE_PARENT)!r}); "
    "from gmfbo.sources.worker.keeper import main; main()"
)
_END_LIMIT_S = 2.0
_CHECK_S = 1.0
_TAIL_BYTES = 300
_LONGEST_LINE_BYTES = 2**24


class WorkerDied(Exception):
    """The worker is gone; `exit_code` is negative where a signal ended it."""

    def __init__(self, exit_code: int) -> None:
        super().__init__(f"worker ended with {exit_code}")
        self.exit_code = exit_code


class WorkerTimeout(Exception):
    """The worker did not answer in time and was killed."""


class WorkerGarbled(Exception):
    """The worker's channel held no valid answer."""


class WorkerProcess:
    """One worker, behind the keeper that starts and outlives it.

    It does not use `multiprocessing`, so a user's script needs no `__main__` guard, and notebooks
    work.

    Parameters
    ----------
    folder : Path
        Private folder, which the worker removes if this process is killed.
    """

    def __init__(self, folder: Path) -> None:
        self._log, self._peak = folder / "worker.log", folder / PEAK_MEMORY
        self._peak.unlink(missing_ok=True)
        self._asked = 0
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _START, str(folder)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                bufsize=0,
                process_group=0,  # one of its own, to be ended as one
            )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._commands: IO[bytes] = self._process.stdin
        self._answers: IO[bytes] = self._process.stdout

    def ask(self, command: Mapping[str, Any], limit_s: float) -> dict[str, Any]:
        """Send a command and wait for its answer.

        Parameters
        ----------
        command : mapping
            Plain values.
        limit_s : float
            [s] Wall-clock time.

        Raises
        ------
        WorkerDied
            It crashed or left.
        WorkerTimeout
            It took longer, and is killed.
        WorkerGarbled
            The answer is invalid.
        """
        self._asked += 1
        asked = {**command, "number": self._asked, "limit_s": limit_s}
        try:
            _write(self._commands, (json.dumps(asked) + "\n").encode())
        except OSError:
            raise WorkerDied(self._reap()) from None
        line = self._read_line(limit_s)
        if not line.endswith(b"\n"):
            raise WorkerDied(self._reap())
        return self._parsed(line)

    def end(self) -> None:
        """Ask the worker to end, and kill it if it does not."""
        with contextlib.suppress(OSError):
            self._commands.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_LIMIT_S)
        self.kill()

    def kill(self) -> None:
        """Kill the worker at once, and wait for its end."""
        _end(self._process)
        self._reap()

    def last_words(self) -> str:
        """End of the output of worker and FMUs, in one line."""
        try:
            with self._log.open("rb") as log:
                log.seek(max(log.seek(0, os.SEEK_END) - _TAIL_BYTES, 0))
                tail = log.read(_TAIL_BYTES)
        except OSError:
            return ""
        return " ".join(tail.decode("utf-8", "replace").split())

    def peak_memory(self) -> int:
        """[bytes] Peak memory of the worker; 0 where unknown."""
        try:
            return int(self._peak.read_text())
        except (OSError, ValueError):
            return 0

    def _parsed(self, line: bytes) -> dict[str, Any]:
        # Foreign code shares the process that answers.
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            raise WorkerGarbled from None
        if not isinstance(answer, dict) or answer.get("number") != self._asked:
            raise WorkerGarbled
        return answer

    def _reap(self) -> int:
        for pipe in (self._commands, self._answers):
            with contextlib.suppress(OSError):
                pipe.close()
        return self._process.wait()

    def _read_line(self, limit_s: float) -> bytes:
        """Read up to a newline, or to the end of a dead worker's pipe."""
        line = b""
        deadline = time.monotonic() + limit_s
        with _killed_at_limit(self._process, limit_s) as killed:
            while not line.endswith(b"\n"):
                left = deadline - time.monotonic()
                if killed() or left <= 0.0:
                    self.kill()
                    raise WorkerTimeout
                if _readable(self._answers, min(left, _CHECK_S)):
                    chunk = os.read(self._answers.fileno(), 65536)
                    if not chunk and not killed():
                        # Foreign code can close the pipe and run on.
                        with contextlib.suppress(subprocess.TimeoutExpired):
                            self._process.wait(max(deadline - time.monotonic(), 0.0))
                            break
                    line += chunk
                    if len(line) > _LONGEST_LINE_BYTES:
                        raise WorkerGarbled
                elif self._process.poll() is not None:
                    break  # the worker is dead, while a child of its FMU holds the pipe open
        return line


def _write(pipe: IO[bytes], text: bytes) -> None:
    rest = memoryview(text)
    while rest:
        rest = rest[pipe.write(rest) :]


if sys.platform == "win32":

    def _end(process: subprocess.Popen[bytes]) -> None:
        process.kill()

    def _readable(pipe: IO[bytes], wait_s: float) -> bool:
        return True  # Windows cannot wait for a pipe; reading ends when the timer kills the worker

    @contextlib.contextmanager
    def _killed_at_limit(
        process: subprocess.Popen[bytes], limit_s: float
    ) -> Iterator[Callable[[], bool]]:
        timer = threading.Timer(limit_s, process.kill)
        timer.start()
        try:
            yield timer.finished.is_set
        finally:
            timer.cancel()

else:

    def _end(process: subprocess.Popen[bytes]) -> None:
        # At SIGTERM, the keeper ends the worker with its children, and reaps them.
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_END_LIMIT_S)
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)

    def _readable(pipe: IO[bytes], wait_s: float) -> bool:
        waiting = select.poll()
        waiting.register(pipe, select.POLLIN)
        return bool(waiting.poll(math.ceil(wait_s * 1000.0)))

    @contextlib.contextmanager
    def _killed_at_limit(
        process: subprocess.Popen[bytes], limit_s: float
    ) -> Iterator[Callable[[], bool]]:
        yield lambda: False  # the wait itself ends at the limit
