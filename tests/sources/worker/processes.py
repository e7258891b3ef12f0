"""Processes as /proc shows them."""

from __future__ import annotations

import os
import time
from pathlib import Path

STANDING = (
    b"multiprocessing.resource_tracker",
    b"gmfbo.recordings.reading_process.reading_program",
)

_earlier: set[int] = set()


def forget_earlier() -> None:
    """Leave out processes that are there by now: fixtures of other files may hold them."""
    _earlier.clear()
    _earlier.update(children())


def children(of: int | None = None) -> list[int]:
    """Processes, zombies too, whose parent is this or that process.

    Standing helpers are not among them, which stay to the end of a process once it needed them:
    Python's tracker of a pool's resources, and the reader of foreign recordings. Nor are those
    that were there before the test.
    """
    parent = of or os.getpid()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status = (entry / "stat").read_text()
                command = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            is_child = int(status.rpartition(")")[2].split()[1]) == parent
            known = int(entry.name) in _earlier or any(name in command for name in STANDING)
            if is_child and not known:
                found.append(int(entry.name))
    return found


def open_files(pid: int) -> int:
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))


def gone_within(pids: list[int], seconds: float) -> bool:
    end = time.monotonic() + seconds
    while any(Path(f"/proc/{pid}").exists() for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def is_stopped(process: int) -> bool:
    """Whether a signal holds it."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "T"


def descendants(of: int) -> list[int]:
    """Processes that this one started, and those that they started."""
    found = []
    for child in children(of):
        found += [child, *descendants(child)]
    return found
