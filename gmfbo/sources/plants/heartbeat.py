"""A file that is touched while somebody waits for a run: the plant notices if nobody does."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

EVERY_S = 0.5
"""[s] Time between two beats."""

LOST_AFTER_S = 2.0
"""[s] Time without a beat after which nobody waits any more: four beats, so that a busy machine is
not taken for a dead one."""


@contextmanager
def beating(path: Path) -> Iterator[None]:
    """Touch a file from another thread, until the block ends.

    Parameters
    ----------
    path : Path
        The file; made at once.
    """
    path.touch()
    ended = threading.Event()

    def beat() -> None:
        while not ended.wait(EVERY_S):
            with suppress(OSError):
                path.touch()

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def lost(path: Path, after_s: float) -> bool:
    """Whether the last beat lies further back than this time [s], or the file is gone."""
    try:
        return time.time() - path.stat().st_mtime > after_s
    except OSError:
        return True
