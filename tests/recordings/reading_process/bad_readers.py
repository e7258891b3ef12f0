"""Readers that behave as foreign libraries do on hostile files."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import NoReturn


def crash(path: Path) -> NoReturn:
    """Die as by a wild pointer."""
    os.kill(os.getpid(), signal.SIGSEGV)
    raise AssertionError("outlived its own signal")


def leave(path: Path) -> NoReturn:
    """Call exit."""
    os._exit(3)


def hang(path: Path) -> NoReturn:
    """Never end."""
    time.sleep(60.0)
    raise AssertionError("was never stopped")


def loop(path: Path) -> NoReturn:
    """Compute for ever, as a library does that follows a list which leads back to its start."""
    while True:
        pass


def fill(path: Path) -> NoReturn:
    """Take all memory."""
    held = []
    while True:
        held.append(bytearray(2**28))


def raise_(path: Path) -> NoReturn:
    """Raise what nobody foresaw."""
    raise ZeroDivisionError("no such\n  thing")


def chatter(path: Path) -> None:
    """Print."""
    print("warning: " + "x" * 100_000)
    os.write(1, b"more\n")


def loop_too(path: Path) -> NoReturn:
    """Compute for ever on another way."""
    loop(path)
