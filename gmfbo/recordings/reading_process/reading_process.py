"""Files of foreign formats are read by another process, which a bad file may crash or hang."""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from gmfbo.errors import RecordingError
from gmfbo.files.durable import cause
from gmfbo.interrupt import signal_name
from gmfbo.recordings.columns.channels import RecordedChannels
from gmfbo.recordings.columns.columns import RecordedColumns
from gmfbo.recordings.reading_process.column_stream import read_columns_from

TIME_LIMIT_S = 20.0
TIME_LIMIT_S_PER_MB = 1.0
PROCESSOR_LIMIT_S = 6.0
"""A library that loops in a damaged file is ended after so much computing, and 1 s a MB.

The slowest of them needs 1 s to be loaded. The limit of time is longer, since it also runs while a
slow disk loads the library itself; on Linux, it is for a library that waits and computes nothing,
so that a busy machine makes no file a damaged one.
"""
SECOND_LIMIT_S = 2.0
"""The same for another way to read a file in which the library has looped before."""
MEMORY_LIMIT_BYTES = 2**30 - 2**27  # with the process itself 1 GiB
MEMORY_LIMIT_PER_BYTE = 20  # per byte of the file; text and compressed files need less

_WAITS_BELOW = 0.01
"""Share of one processor below which a process waits."""

_PACKAGE_PARENT = Path(__file__).resolve().parents[3]
# As for the FMU's worker, no module of the working folder may shadow ours.
_START = (
    f"import sys; sys.path.append({str(_PACKAGE_PARENT)!r}); "
    "from gmfbo.recordings.reading_process.reading_program import main; main()"
)


Reader = Callable[[Path], RecordedColumns | RecordedChannels]
"""Takes a path; a module's function, which the other process can import."""


def read_apart(path: Path, reader: Reader) -> RecordedColumns | RecordedChannels:
    """Read a file in the reading process, which is started at first use and kept.

    Parameters
    ----------
    path : Path
        File.
    reader : callable
        Takes the path; a function of a module.

    Raises
    ------
    RecordingError
        The reader refused the file, crashed, took too long, or needed too much memory.
    """
    answer = _ask(path, reader)
    assert answer is not None
    return answer


def try_apart(path: Path, attempt: Callable[..., None], **arguments: str) -> None:
    """Try an operation on a file in the reading process before this process does it.

    Parameters
    ----------
    path : Path
        File.
    attempt : callable
        Takes the path and the arguments; a function of a module.
    **arguments
        Further arguments.

    Raises
    ------
    RecordingError
        The process refused the file, crashed, took too long, or needed too much memory.
    """
    _ask(path, attempt, **arguments)


def _ask(
    path: Path, function: Callable[..., Any], **arguments: str
) -> RecordedColumns | RecordedChannels | None:
    found = path.stat()
    size, key = found.st_size, (path.absolute(), found.st_size, found.st_mtime_ns)
    looped = _looped.get(key, {})
    if function in looped:
        raise RecordingError(looped[function])
    limit_s = TIME_LIMIT_S + TIME_LIMIT_S_PER_MB * size / 1e6
    order = {
        "path": path.absolute(),
        "function": function,
        "arguments": arguments,
        "memory_bytes": MEMORY_LIMIT_BYTES + MEMORY_LIMIT_PER_BYTE * size,
        # Only in case this process is gone by then: at least the share above was computed.
        "seconds": limit_s + PROCESSOR_LIMIT_S / _WAITS_BELOW,
        "processor_s": SECOND_LIMIT_S
        if looped
        else PROCESSOR_LIMIT_S + TIME_LIMIT_S_PER_MB * size / 1e6,
    }
    with _turn:
        try:
            answer = _process().ask(order, limit_s, path.name)
        except _LoopedError as error:
            _looped.setdefault(key, {})[function] = str(error)
            raise
    if isinstance(answer, str):
        raise RecordingError(answer)
    return answer


class _LoopedError(RecordingError):
    """The library computed without an end; it would do so again."""


class ReadingProcess:
    """One process that reads; replaced when a file has ended it."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _START],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        except OSError as error:
            raise RecordingError(f"no process can be started to read: {cause(error)}") from error
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._orders: IO[bytes] = self._process.stdin
        self._answers: IO[bytes] = self._process.stdout
        self.usable = self._answers.readline() == b"ready\n"

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def ask(
        self, order: dict[str, object], limit_s: float, label: str
    ) -> RecordedColumns | RecordedChannels | str | None:
        """Have a file read; a refusal is returned as its message.

        Raises
        ------
        RecordingError
            The process crashed or was stopped at the time limit.
        """
        late, answered = threading.Event(), threading.Event()
        watch = threading.Thread(
            target=self._end_where_it_waits, args=(limit_s, answered, late), daemon=True
        )
        watch.start()
        done = False
        try:
            pickle.dump(order, self._orders)
            self._orders.flush()
            answer = read_columns_from(self._answers)
            done = True
            return answer
        except (EOFError, ValueError, KeyError, OSError):
            why, kind = f"did not end within {limit_s:.0f} s", RecordingError
            if not late.is_set():
                why, kind = self._end_reason(float(str(order["processor_s"])))
            raise kind(
                f"{label}: the library that reads such files {why}; the file is damaged or "
                "hostile, write or copy it again"
            ) from None
        finally:
            answered.set()
            watch.join()
            # After an interrupt an answer may be half read, so the process is ended too.
            if not done or late.is_set():
                self.close()

    def _end_where_it_waits(
        self, limit_s: float, answered: threading.Event, late: threading.Event
    ) -> None:
        """End the process once it has computed next to nothing for so long."""
        before = _computed_s(self.pid)
        while not answered.wait(limit_s):
            now = _computed_s(self.pid)
            if now - before < _WAITS_BELOW * limit_s:
                late.set()
                self._process.kill()
                return
            before = now

    def _end_reason(self, processor_s: float) -> tuple[str, type[RecordingError]]:
        status = self._process.wait()
        if status < 0 and signal_name(status) == "SIGXCPU":
            return f"did not end within {processor_s:.0f} s of computing", _LoopedError
        how = signal_name(status) if status < 0 else f"exit status {status}"
        return f"crashed ({how})", RecordingError

    def close(self) -> None:
        """End the process; a second call does nothing."""
        self.usable = False
        if os.getpid() != self.owner:  # a forked child must not end its parent's
            return
        self._process.kill()
        for pipe in (self._orders, self._answers):
            try:
                pipe.close()
            except OSError:
                continue  # buffered data can no longer be written
        self._process.wait()


def _computed_s(pid: int) -> float:
    """Processor time [s] of a process; zero where the system does not tell it in /proc."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return 0.0
    user, system = text.rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


_turn = threading.Lock()
_looped: dict[tuple[Path, int, int], dict[Callable[..., Any], str]] = {}
"""Refusals by file, as path, size and time of change, and by function."""
_running: list[ReadingProcess] = []


def _process() -> ReadingProcess:
    if _running and (not _running[0].usable or _running[0].owner != os.getpid()):
        _running.clear()
    if not _running:
        _running.append(ReadingProcess())
        if not _running[0].usable:
            raise RecordingError(
                f"no process can be started to read: {sys.executable} did not answer; check the "
                "installation"
            )
    return _running[0]


@atexit.register
def end_reading() -> None:
    """End the reading process, if one runs; the next file starts another."""
    for process in _running:
        process.close()
    _running.clear()
