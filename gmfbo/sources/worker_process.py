"""A worker as its parent sees it: started, asked, ended."""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

_PACKAGE_PARENT = Path(__file__).resolve().parents[2]
# -P keeps modules of the user's working folder from standing in for ours; the parent's copy of
# this package is found even where it is not installed.
_START = (
    f"import sys; sys.path.append({str(_PACKAGE_PARENT)!r}); "
    "from gmfbo.sources.worker import main; main()"
)
_END_LIMIT_S = 2.0
_CHECK_S = 1.0
_TAIL_BYTES = 300


class WorkerDied(Exception):
    """The worker is gone; `exit_code` is negative where a signal ended it."""

    def __init__(self, exit_code: int) -> None:
        super().__init__(f"worker ended with {exit_code}")
        self.exit_code = exit_code


class WorkerTimeout(Exception):
    """The worker did not answer in time and was killed."""


class WorkerProcess:
    """One worker.

    It is no `multiprocessing` process, so that a user's script needs no `__main__` guard and a
    notebook works.

    Parameters
    ----------
    folder : Path
        Private folder, which the worker removes if this process is killed.
    """

    def __init__(self, folder: Path) -> None:
        self._log = folder / "worker.log"
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _START, str(folder)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                bufsize=0,
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
        """
        try:
            _write(self._commands, (json.dumps(command) + "\n").encode())
        except OSError:
            raise WorkerDied(self._reap()) from None
        line = self._read_line(limit_s)
        if not line.endswith(b"\n"):
            raise WorkerDied(self._reap())
        answer: dict[str, Any] = json.loads(line)
        return answer

    def end(self) -> None:
        """Let it leave by itself, and kill it if it does not."""
        with contextlib.suppress(OSError):
            self._commands.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_LIMIT_S)
        self.kill()

    def kill(self) -> None:
        """End it at once and wait until it is gone."""
        self._process.kill()
        self._reap()

    def last_words(self) -> str:
        """End of what it and its FMUs printed, in one line."""
        try:
            tail = self._log.read_bytes()[-_TAIL_BYTES:]
        except OSError:
            return ""
        return " ".join(tail.decode("utf-8", "replace").split())

    def _reap(self) -> int:
        for pipe in (self._commands, self._answers):
            with contextlib.suppress(OSError):
                pipe.close()
        return self._process.wait()

    def _read_line(self, limit_s: float) -> bytes:
        """Read up to a newline, or to the end of the pipe where the worker is gone."""
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
                        break
                    line += chunk
                elif self._process.poll() is not None:
                    break  # gone, while a process that its FMU started holds the pipe open
        return line


def _write(pipe: IO[bytes], text: bytes) -> None:
    rest = memoryview(text)
    while rest:
        rest = rest[pipe.write(rest) :]


if sys.platform == "win32":

    def _readable(pipe: IO[bytes], wait_s: float) -> bool:
        return True  # pipes cannot be waited for; reading ends when the timer kills the worker

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

    def _readable(pipe: IO[bytes], wait_s: float) -> bool:
        waiting = select.poll()
        waiting.register(pipe, select.POLLIN)
        return bool(waiting.poll(math.ceil(wait_s * 1000.0)))

    @contextlib.contextmanager
    def _killed_at_limit(
        process: subprocess.Popen[bytes], limit_s: float
    ) -> Iterator[Callable[[], bool]]:
        yield lambda: False  # the wait itself ends at the limit
