"""Program of the reading process: reads files on request, one after the other.

Readers of HDF5, Parquet, MAT, MDF and TDMS are foreign native code. A damaged or hostile file may
crash it, hang it or fill the memory; this then ends this process only.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from gmfbo.errors import GmfboError
from gmfbo.files.durable import cause
from gmfbo.recordings.reading_process.column_stream import write_columns, write_refusal


def main() -> None:
    """Answer on the original standard output, until standard input ends."""
    with os.fdopen(os.dup(1), "wb") as answers:
        # Prints of libraries must not mix with the answers.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the waiting parent
        _write_no_core()
        answers.write(b"ready\n")
        answers.flush()
        for order in _orders():
            limit_memory(order["memory_bytes"])
            _end_after(order["seconds"])
            _limit_computing(order["processor_s"])
            _answer(answers, order)
            answers.flush()
            _end_after(0.0)


def _orders() -> Iterator[dict[str, Any]]:
    """Orders of the parent process, which is trusted, each with the function to call."""
    with contextlib.suppress(EOFError):
        while True:
            yield pickle.load(sys.stdin.buffer)


def _answer(answers: IO[bytes], order: dict[str, Any]) -> None:
    path: Path = order["path"]
    try:
        read = order["function"](path, **order["arguments"])
    except GmfboError as error:
        write_refusal(answers, str(error))
    except OSError as error:
        write_refusal(answers, f"{path}: cannot be read: {cause(error)}")
    except MemoryError:
        write_refusal(answers, f"{path.name}: {TOO_LARGE}")
    except Exception as error:
        # Any exception of a library is the file's fault.
        why = " ".join(f"{type(error).__name__}: {error}".split())
        write_refusal(
            answers,
            f"{path.name}: damaged, or not of the kind that its name says ({why}); write or copy "
            "it again",
        )
    else:
        write_columns(answers, read)


def _end_after(seconds: float) -> None:
    """Have the system end this process after a time, in case the parent was killed; 0 is never."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _limit_computing(seconds: float) -> None:
    """Have the system end this process once it has computed so long; Windows has no such limit."""
    if sys.platform != "win32":
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        computed = used.ru_utime + used.ru_stime
        # The system counts whole seconds; one at least is left.
        limit = max(math.floor(computed + seconds), math.ceil(computed) + 1)
        hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
        with contextlib.suppress(ValueError, OSError):
            soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
            resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))


def _write_no_core() -> None:
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


TOO_LARGE = (
    "its contents need far more memory than a file of its size should; it is damaged or made to "
    "fill the memory, write it again"
)


def limit_memory(more_bytes: int) -> None:
    """Limit the growth of this process; Windows and macOS have no such limit."""
    if not sys.platform.startswith("linux"):
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + more_bytes
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(
            resource.RLIMIT_AS,
            (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard),
        )
