"""Noticing that the parent process is gone, even while a native call hangs."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable

_CHECK_MS = 1000


def when_parent_is_gone(pipe: int, action: Callable[[], None]) -> None:
    """Call an action, from a thread of its own, once the parent process has ended.

    Parameters
    ----------
    pipe : int
        File descriptor of a pipe whose other end the parent holds.
    action : callable
        Ends this process.
    """
    parent = os.getppid()

    def watch() -> None:
        _wait_for_end(pipe, parent)
        action()

    threading.Thread(target=watch, daemon=True).start()


if sys.platform == "win32":

    def _wait_for_end(pipe: int, parent: int) -> None:
        import ctypes

        synchronize, forever = 0x00100000, 0xFFFFFFFF
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenProcess.restype = ctypes.c_void_p
        handle = ctypes.c_void_p(kernel.OpenProcess(synchronize, False, parent))
        kernel.WaitForSingleObject(handle, forever)

else:

    def _wait_for_end(pipe: int, parent: int) -> None:
        import select

        hang_up = select.poll()
        hang_up.register(pipe, select.POLLHUP)
        # A process forked from the parent may hold the pipe open after the parent's end, so the
        # parent's number is looked at too.
        while not hang_up.poll(_CHECK_MS) and os.getppid() == parent:
            pass
