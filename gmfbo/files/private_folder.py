"""A temporary folder that is gone once its owner is, however the owner ended."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import weakref
from pathlib import Path
from typing import IO

_PREFIX = "gmfbo-twin-"
_LOCK = "owner.lock"
_ALONE_AFTER_S = 60.0


class PrivateFolder:
    """A folder for one twin's unpacked FMUs and shared arrays.

    The owner holds a lock in it, which the system releases however the owner dies. A folder that
    is found unlocked was left by a process that was killed together with its worker, and is
    removed by whoever makes the next one.
    """

    def __init__(self) -> None:
        _remove_abandoned()
        self._owner = os.getpid()
        self.path = Path(tempfile.mkdtemp(prefix=_PREFIX))
        lock = (self.path / _LOCK).open("wb")
        _try_lock(lock)
        # Called when this object is forgotten too, and at the interpreter's end.
        self._remove = weakref.finalize(self, _remove, self.path, lock, self._owner)

    @property
    def is_mine(self) -> bool:
        """This process made it, and is not a forked copy of the one that did."""
        return os.getpid() == self._owner

    def remove(self) -> None:
        """Remove the folder and all in it; nothing in a forked copy, or a second time."""
        self._remove()


def _remove(path: Path, lock: IO[bytes], owner: int) -> None:
    if os.getpid() == owner:
        lock.close()
        remove_tree(path)


def remove_tree(path: Path) -> None:
    """Remove a folder and all in it, as far as this process may.

    Parameters
    ----------
    path : Path
        May hold more levels of folders than Python can recurse through: foreign code made them.
    """
    try:
        shutil.rmtree(path, ignore_errors=True)
    except RecursionError:
        subprocess.run(["rm", "-rf", "--", str(path)], check=False, capture_output=True)


def _remove_abandoned() -> None:
    for folder in Path(tempfile.gettempdir()).glob(_PREFIX + "*"):
        # Another user's folder, or one that vanishes meanwhile, is not ours to complain about.
        with contextlib.suppress(OSError):
            # A folder is locked a moment after it is made.
            if time.time() - folder.stat().st_mtime < _ALONE_AFTER_S:
                continue
            with (folder / _LOCK).open("r+b") as lock:
                abandoned = _try_lock(lock)
            if abandoned:
                remove_tree(folder)


def _try_lock(lock: IO[bytes]) -> bool:
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(lock.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
