"""Shelf of a worker: received files, each content once."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path

from gmfbo.files.private_folder import PrivateFolder


class Shelf:
    """Folder of this process for contents by hash, and for trees of files made of them."""

    def __init__(self) -> None:
        self._folder = PrivateFolder()
        self._lock = threading.Lock()  # a worker may have several threads

    @property
    def is_there(self) -> bool:
        """Whether the folder exists and belongs to this process."""
        return self._folder.is_mine and self._folder.path.exists()

    def missing(self, hashes: Iterable[str]) -> frozenset[str]:
        """Hashes of contents that are missing here.

        Parameters
        ----------
        hashes : iterable of str
            SHA-256 of each.
        """
        return frozenset(digest for digest in hashes if not self._content(digest).exists())

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Keep contents, given by their SHA-256."""
        with self._lock:
            for digest, content in contents.items():
                self._content(digest).write_bytes(content)

    def tree(self, hashes: Mapping[str, str], folder: str) -> Path:
        """Folder with these files; made once.

        Parameters
        ----------
        hashes : mapping of str to str
            Relative path with slashes = hash; all contents have been put here.
        folder : str
            Relative path of a folder to make even if it is empty, since relative paths may start
            there.
        """
        name = hashlib.sha256(repr((folder, sorted(hashes.items()))).encode()).hexdigest()
        root = self._folder.path / f"tree-{name}"
        with self._lock:
            if not root.exists():
                unfinished = root.with_suffix(".tmp")
                (unfinished / folder).mkdir(parents=True)
                for path, digest in hashes.items():
                    self.place(digest, unfinished / path)
                unfinished.rename(root)
        return root

    def place(self, digest: str, path: Path) -> None:
        """Write a content to a path.

        Parameters
        ----------
        digest : str
            Its hash.
        path : Path
            Of the file, which does not exist.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(OSError):
            os.link(self._content(digest), path)
            return
        shutil.copyfile(self._content(digest), path)

    def _content(self, digest: str) -> Path:
        return self._folder.path / f"content-{digest}"


_SHELVES: list[Shelf] = []


def own_shelf() -> Shelf:
    """The shelf of this process; a new one if its folder was removed."""
    if not (_SHELVES and _SHELVES[-1].is_there):
        _SHELVES[:] = [Shelf()]
    return _SHELVES[-1]
