"""A temporary folder that is removed after its owner's end, however that came."""

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

    The owner holds a lock in the folder, which the system releases at the owner's end. An unlocked
    folder was left by a process that was killed together with its worker; whoever makes the next
    folder removes it.
    """

    def __init__(self) -> None:
        _remove_abandoned()
        self._owner = os.getpid()
        self.path = Path(tempfile.mkdtemp(prefix=_PREFIX))
        lock = (self.path / _LOCK).open("wb")
        _try_lock(lock)
        # Also called when this object is garbage collected, and at the interpreter's end.
        self._remove = weakref.finalize(self, _remove, self.path, lock, self._owner)

    @property
    def is_mine(self) -> bool:
        """Whether this process made the folder, and is no forked copy of its maker."""
        return os.getpid() == self._owner

    def remove(self) -> None:
        """Remove the folder with its content; does nothing in a forked copy, or a second time."""
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
        It may hold more levels of folders than Python can recurse through, by foreign code.
    """
    try:
        shutil.rmtree(path, ignore_errors=True)
    except RecursionError:
        subprocess.run(["rm", "-rf", "--", str(path)], check=False, capture_output=True)


def _remove_abandoned() -> None:
    for folder in Path(tempfile.gettempdir()).glob(_PREFIX + "*"):
        # Another user's folder, or one that vanishes meanwhile, is no error.
        with contextlib.suppress(OSError):
            # A new folder is locked only a moment after it is made.
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
