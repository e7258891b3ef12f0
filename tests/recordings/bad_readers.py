"""Readers that behave as foreign libraries do on hostile files."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def crash(path: Path) -> None:
    """Die as by a wild pointer."""
    os.kill(os.getpid(), signal.SIGSEGV)


def leave(path: Path) -> None:
    """Call exit."""
    os._exit(3)


def hang(path: Path) -> None:
    """Never end."""
    time.sleep(60.0)


def fill(path: Path) -> None:
    """Take all memory."""
    held = []
    while True:
        held.append(bytearray(2**28))


def raise_(path: Path) -> None:
    """Raise what nobody foresaw."""
    raise ZeroDivisionError("no such\n  thing")


def chatter(path: Path) -> None:
    """Print."""
    print("warning: " + "x" * 100_000)
    os.write(1, b"more\n")
