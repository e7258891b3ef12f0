"""Resource limits of a process (POSIX setrlimit)."""

from __future__ import annotations

import contextlib
import os
import sys

LARGEST_FILE_BYTES = 2**30
MOST_OPEN_FILES = 512

if sys.platform == "win32":

    def forgo_dumps() -> None:
        """Do nothing."""

    def set_limits(memory: int) -> None:
        """Do nothing: Windows has no such limits for a process that runs."""

    def limit_processor_time(run_limit_s: float) -> None:
        """Do nothing."""

else:
    import resource

    def forgo_dumps() -> None:
        """Write no core dumps: a crash is expected."""
        _lower(resource.RLIMIT_CORE, 0)

    def set_limits(memory: int) -> None:
        """Limit memory and files; they cannot be raised again.

        Parameters
        ----------
        memory : int
            [bytes] Private memory; 0 for no limit.
        """
        if memory and sys.platform == "linux":  # macOS accepts the limit without enforcing it
            _lower(resource.RLIMIT_DATA, memory)
        _lower(resource.RLIMIT_FSIZE, LARGEST_FILE_BYTES)
        _lower(resource.RLIMIT_NOFILE, MOST_OPEN_FILES)

    def limit_processor_time(run_limit_s: float) -> None:
        """Limit processor time from now on; the wall clock is the parent's to watch.

        Parameters
        ----------
        run_limit_s : float
            [s] Wall-clock time of a run; all processors may be busy that long.
        """
        used = resource.getrusage(resource.RUSAGE_SELF)
        seconds = used.ru_utime + used.ru_stime + run_limit_s * (os.cpu_count() or 1)
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        with contextlib.suppress(ValueError, OverflowError, OSError):
            resource.setrlimit(resource.RLIMIT_CPU, (max(int(seconds), 0) + 1, hard))

    def _lower(what: int, limit: int) -> None:
        _, hard = resource.getrlimit(what)
        lower = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(what, (lower, lower))
