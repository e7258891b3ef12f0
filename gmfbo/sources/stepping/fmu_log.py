"""Log of each FMU: its last lines, through one callback for all."""

from __future__ import annotations

import contextlib
import ctypes
from functools import lru_cache
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import fmpy.fmi2

_KEPT = 5
_OK = 0
_numbers = count(1)
_logs: WeakValueDictionary[int, FmuLog] = WeakValueDictionary()


class FmuLog:
    """Last warnings and errors of one FMU.

    Attributes
    ----------
    callbacks : ctypes.Structure
        Argument of `fmi2Instantiate`; its `componentEnvironment` comes back with each line and
        tells the FMU.
    lines : list of str
        Newest last.
    """

    def __init__(self) -> None:
        self._number = next(_numbers)
        self.lines: list[str] = []
        self.callbacks = fmpy.fmi2.fmi2CallbackFunctions.from_buffer_copy(_shared_callbacks())
        self.callbacks.componentEnvironment = self._number
        _logs[self._number] = self

    def note(self, status: int, message: bytes | None) -> None:
        """Keep a warning or error; only the last few stay."""
        line = " ".join((message or b"").decode("utf-8", "replace").split())
        if status > _OK and line:
            self.lines.append(line)
            del self.lines[:-_KEPT]


@lru_cache(maxsize=1)
def _shared_callbacks() -> Any:
    """Callbacks that all FMUs share, since fmpy's C library has a single logger."""
    callbacks = fmpy.fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(_keep)
    callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
    # A message is a printf format with arguments, which only C can format. On some machines fmpy
    # has no library for that, and the bare format is kept.
    with contextlib.suppress(Exception):
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


def _keep(
    environment: int | None, name: bytes, status: int, category: bytes, message: bytes | None
) -> None:
    log = _logs.get(environment or 0)
    if log is not None:
        log.note(status, message)
