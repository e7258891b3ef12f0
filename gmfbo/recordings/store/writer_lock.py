"""Writer lock: one writer a study; the operating system frees it when the process dies."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from gmfbo.errors import StoreError

# The system lets a process lock its own lock again, so the locks of this process are kept here.
_held: set[Path] = set()


class WriterLock:
    """Exclusive right to write a study folder, from construction to `release`.

    A record lock rather than `flock`: a forked child does not inherit it, so a killed writer's
    surviving children cannot keep the study locked.

    Parameters
    ----------
    path : Path
        Lock file, made where it is missing and never removed: removing it would let two
        processes lock two files of one name.

    Raises
    ------
    StoreError
        Another writer has the study.
    OSError
        The lock file cannot be opened for writing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.resolve()
        if self._path in _held:
            raise StoreError(self._refusal("this process"))
        self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _lock(self._descriptor)
        except OSError as error:
            holder = os.read(self._descriptor, 32).decode("ascii", errors="replace").strip()
            os.close(self._descriptor)
            raise StoreError(self._refusal(f"process {holder or 'of another user'}")) from error
        # The process id is information only, so a full disk must not keep a writer out.
        with contextlib.suppress(OSError):
            os.ftruncate(self._descriptor, 0)
            os.lseek(self._descriptor, 0, os.SEEK_SET)
            os.write(self._descriptor, f"{os.getpid()}\n".encode())
        _held.add(self._path)

    def release(self) -> None:
        """Let the next writer in; a second call does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
            _held.discard(self._path)

    def _refusal(self, holder: str) -> str:
        return (
            f"{self._path.parent}: {holder} is writing this study; wait for it to end, or read "
            "the study meanwhile"
        )


if os.name == "nt":
    import msvcrt

    def _lock(descriptor: int) -> None:
        # Lock a byte far behind the process id, which others must be able to read.
        os.lseek(descriptor, 1 << 20, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        finally:
            os.lseek(descriptor, 0, os.SEEK_SET)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
