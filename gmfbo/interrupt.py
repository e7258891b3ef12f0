"""Ctrl-C that is not lost on its way, in a callback or a compiled library; names of signals.

Python drops it in a weak reference's callback and prints a traceback, which
nobody who pressed the keys wants. A library that calls Python back may hand it on as a
SystemError.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def remembered_interrupt() -> Iterator[threading.Event]:
    """Record Ctrl-C, besides raising KeyboardInterrupt as always.

    Yields
    ------
    threading.Event
        Set once it was pressed.
    """
    pressed = threading.Event()
    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:
        yield pressed  # Ctrl-C is ignored, or another handler is set
        return

    def note(*_: object) -> None:
        pressed.set()
        raise KeyboardInterrupt

    tell = sys.unraisablehook

    def tell_others(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            tell(dropped)

    signal.signal(signal.SIGINT, note)
    sys.unraisablehook = tell_others
    try:
        yield pressed
    finally:
        sys.unraisablehook = tell
        signal.signal(signal.SIGINT, before)


@contextmanager
def unwrapped_interrupt() -> Iterator[None]:
    """Raise KeyboardInterrupt where a compiled library turned it into a SystemError."""
    try:
        yield
    except SystemError as error:
        reason = error.__cause__
        while reason is not None and not isinstance(reason, KeyboardInterrupt):
            reason = reason.__cause__
        if reason is None:
            raise
        raise KeyboardInterrupt from error


def signal_name(status: int) -> str:
    """Name of the signal that a negative exit status stands for: `SIGKILL`, or `signal 77`."""
    try:
        return signal.Signals(-status).name
    except ValueError:
        return f"signal {-status}"
