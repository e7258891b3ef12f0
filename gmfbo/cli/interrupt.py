"""Ctrl-C that is not lost: Python drops it where it lands in a weak reference's callback."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def remembered_interrupt() -> Iterator[threading.Event]:
    """Remember that Ctrl-C was pressed, besides raising KeyboardInterrupt as always.

    Yields
    ------
    threading.Event
        Set once it was pressed.
    """
    pressed = threading.Event()
    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:
        yield pressed  # ignored, or somebody else's
        return

    def note(*_: object) -> None:
        pressed.set()
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)
