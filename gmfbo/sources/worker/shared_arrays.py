"""Arrays shared by a twin's process and its worker, through a mapped file."""

from __future__ import annotations

import mmap
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gmfbo.errors import SimulationError

_HEADER_BYTES = 64
_CHUNK_BYTES = 2**20


class SharedArrays:
    """A header of two integers and room for arrays of doubles.

    Parameters
    ----------
    path : Path
        An existing file that was made by `reserve`.

    Attributes
    ----------
    progress : ndarray, shape (2,), int64
        Stage and FMU that the worker is busy with; outlives its crash.
    """

    def __init__(self, path: Path) -> None:
        with path.open("r+b") as file:
            self._map = mmap.mmap(file.fileno(), 0)
        self.progress: NDArray[np.int64] = np.frombuffer(self._map, np.int64, 2)

    @property
    def room(self) -> int:
        """Number of doubles that fit."""
        return (len(self._map) - _HEADER_BYTES) // 8

    def arrays(self, shapes: tuple[tuple[int, int], ...]) -> list[NDArray[np.float64]]:
        """Lay out arrays of these shapes, one after the other.

        Parameters
        ----------
        shapes : tuple of tuple of int
            In all at most `room` doubles.
        """
        arrays, offset = [], _HEADER_BYTES
        for rows, columns in shapes:
            flat = np.frombuffer(self._map, np.float64, rows * columns, offset)
            arrays.append(flat.reshape(rows, columns))
            offset += flat.nbytes
        return arrays


def reserve(path: Path, doubles: int) -> None:
    """Make a file with room for arrays, and allocate its disk space.

    On a full disk, writing to a mapped file without allocated space kills the process.

    Parameters
    ----------
    path : Path
        Does not exist yet.
    doubles : int
        Number of doubles.

    Raises
    ------
    SimulationError
        The disk is full.
    """
    size = _HEADER_BYTES + 8 * doubles
    try:
        with path.open("xb") as file:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
                return
            for start in range(0, size, _CHUNK_BYTES):
                file.write(bytes(min(_CHUNK_BYTES, size - start)))
    except OSError as error:
        path.unlink(missing_ok=True)
        raise SimulationError(
            f"cannot reserve {size / 1e6:.3g} MB for a run in '{path.parent}': "
            f"{error.strerror or error}; free some space or set TMPDIR to a folder with room"
        ) from None
