"""Keeper: the process between gmfbo and the worker, which ends leftovers and cleans up.

gmfbo starts the keeper, which forks the worker before anything large is loaded, waits, and takes no
part in a run. The worker encloses itself and so cannot remove its own folder, and processes that an
FMU leaves behind have to end with it. On Windows there is no fork: worker and keeper are one.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import traceback
from pathlib import Path
from typing import NoReturn

from gmfbo.files.private_folder import remove_tree
from gmfbo.sources.sandbox.limits import forgo_dumps

_CHECK_MS = 1000
_COMMANDS, _ANSWERS = 0, 1
PEAK_MEMORY = "peak_memory"
"""File in the private folder with the peak memory [bytes] of a dead worker."""


def main() -> None:
    """Keep a worker until it ends, gmfbo ends, or SIGTERM comes."""
    folder = Path(sys.argv[1])
    # A keyboard interrupt reaches the whole group; the parent alone decides about it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "win32":
        from gmfbo.sources.worker.worker_start import serve

        serve(folder)
    else:
        _Keeper(folder).keep()


if sys.platform != "win32":

    class _Keeper:
        """Parent of the worker."""

        def __init__(self, folder: Path) -> None:
            self._folder = folder
            self._parent = os.getppid()
            self._asked_to_end = False
            self._awake, wake = os.pipe()
            os.set_blocking(self._awake, False)
            os.set_blocking(wake, False)
            signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
            signal.signal(signal.SIGCHLD, lambda *_: None)
            signal.signal(signal.SIGTERM, self._note_wish)
            if sys.platform == "linux":
                from gmfbo.sources.sandbox.kernel import adopt_orphans

                with contextlib.suppress(OSError):
                    adopt_orphans()
            self._worker = self._fork(wake)
            import psutil  # after the fork: the worker needs none, and what it holds is counted

            self._process = psutil.Process()

        def keep(self) -> NoReturn:
            nothing = os.open(os.devnull, os.O_RDWR)
            os.dup2(nothing, _ANSWERS)  # so that the pipe ends for gmfbo when the worker ends
            status = None
            while status is None and not self._is_alone() and not self._asked_to_end:
                self._wait()
                status = self._ended()
            self._end_descendants(worker_too=status is None)
            if self._is_alone():
                remove_tree(self._folder)
            _leave_as(status)

        def _note_wish(self, *_: object) -> None:
            self._asked_to_end = True

        def _fork(self, wake: int) -> int:
            keeper = os.getpid()
            worker = os.fork()
            if worker:
                return worker
            try:
                signal.set_wakeup_fd(-1)
                for number in (signal.SIGCHLD, signal.SIGTERM):
                    signal.signal(number, signal.SIG_DFL)
                os.close(wake)
                os.close(self._awake)
                _die_with(keeper)
                from gmfbo.sources.worker.worker_start import serve

                serve(self._folder)
                os._exit(0)
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(1)

        def _wait(self) -> None:
            waiting = select.poll()
            waiting.register(_COMMANDS, 0)  # reports the end of the pipe only
            waiting.register(self._awake, select.POLLIN)
            waiting.poll(_CHECK_MS)
            with contextlib.suppress(BlockingIOError):
                os.read(self._awake, 4096)

        def _is_alone(self) -> bool:
            """Whether gmfbo has ended, or closed the pipe since it needs no worker.

            A process forked from gmfbo may hold the pipe open after gmfbo's end, so the parent's
            process id is checked too.
            """
            hang_up = select.poll()
            hang_up.register(_COMMANDS, 0)
            return bool(hang_up.poll(0)) or os.getppid() != self._parent

        def _ended(self) -> int | None:
            """Status of the worker if it ended; other ended children are reaped too."""
            with contextlib.suppress(ChildProcessError):
                while (ended := os.wait4(-1, os.WNOHANG))[0]:
                    if ended[0] == self._worker:
                        self._tell_memory(ended[2].ru_maxrss)
                        return ended[1]
            return None

        def _tell_memory(self, peak: int) -> None:
            unit = 1024 if sys.platform == "linux" else 1
            with contextlib.suppress(OSError):
                (self._folder / PEAK_MEMORY).write_text(str(unit * peak))

        def _end_descendants(self, *, worker_too: bool) -> None:
            doomed = [self._worker] if worker_too else []
            with contextlib.suppress(ChildProcessError):
                while True:
                    for child in {*doomed, *(child.pid for child in self._process.children())}:
                        with contextlib.suppress(ProcessLookupError):
                            os.kill(child, signal.SIGKILL)
                    gone, _ = os.waitpid(-1, 0)
                    doomed = [child for child in doomed if child != gone]

    def _die_with(keeper: int) -> None:
        if sys.platform == "linux":
            from gmfbo.sources.sandbox.kernel import end_with_parent

            with contextlib.suppress(OSError):
                end_with_parent(signal.SIGKILL)
        if os.getppid() != keeper:
            os._exit(0)

    def _leave_as(status: int | None) -> NoReturn:
        """End with the status or signal of the worker, for gmfbo to see."""
        if status is not None and os.WIFSIGNALED(status):
            number = os.WTERMSIG(status)
            with contextlib.suppress(OSError, ValueError):
                forgo_dumps()
                signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        os._exit(os.WEXITSTATUS(status) if status is not None else 0)
