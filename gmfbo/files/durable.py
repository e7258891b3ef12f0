"""Write files whole or not at all, whatever kills the process."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

BINARY = getattr(os, "O_BINARY", 0)  # without this flag Windows changes line ends

_MEANING = {
    errno.ENOSPC: "the disk is full; free some space",
    errno.EDQUOT: "the disk quota is used up; free some space",
    errno.EFBIG: "the file is larger than this account may write; raise the limit",
    errno.EROFS: "the file system is read-only; choose another folder",
    errno.EACCES: "no permission to write there; choose another folder or change its rights",
    errno.EPERM: "writing there is not permitted; choose another folder or change its rights",
    errno.ENOENT: "the folder does not exist; create it first",
    errno.ENOTDIR: "a part of the path is a file, not a folder; choose another folder",
    errno.EISDIR: "this is a folder, not a file; give a file name",
    errno.ENAMETOOLONG: "the file name is too long; choose a shorter one",
}


def write_whole(path: Path, content: bytes, *, durable: bool = True) -> None:
    """Write a file so that readers and crashes see the old or the new file, nothing between.

    The bytes go to a temporary file in the same folder, which is synced and renamed in one step.
    Then the folder is synced, without which a power cut may undo the new name.

    Parameters
    ----------
    path : Path
        The file.
    content : bytes
        Its whole content.
    durable : bool
        Sync to the disk; without it a power cut, but no killed process, may lose the file.

    Raises
    ------
    OSError
        The file could not be written; nothing is left behind, and an older file is untouched.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | BINARY, 0o666)
        try:
            write_fully(descriptor, content)
            if durable:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)
        temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    if durable:
        sync_folder(path.parent)


def write_fully(descriptor: int, content: bytes) -> None:
    """Write all bytes; `os.write` alone may stop short of a full disk's last block."""
    view = memoryview(content)
    while view:
        view = view[os.write(descriptor, view) :]


def sync_folder(folder: Path) -> None:
    """Make names in this folder survive a power cut; Windows needs no such call."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def remove_stale(folder: Path) -> list[str]:
    """Remove temporary files that a killed writer left; returns their names."""
    stale = sorted(folder.glob(".*.tmp"))
    for path in stale:
        path.unlink(missing_ok=True)
    return [path.name for path in stale]


def cause(error: OSError) -> str:
    """Words for the operating system's error, with its cure."""
    known = _MEANING.get(error.errno or 0)
    return known if known else f"{error.strerror or error}; choose another place"
