"""The index of a study: external links that show all trials as one HDF5 file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py

from gmfbo.files.durable import write_whole
from gmfbo.recordings.store.seal import read_seal, sealed
from gmfbo.recordings.writing.hdf5_group import file_image

INDEX_NAME = "index.h5"


def trial_name(number: int) -> str:
    """Name of a trial's group, and of its file without the ending: 000001."""
    return f"{number:06d}"


def write_index(folder: Path, numbers: Iterable[int], study_text: str) -> Path:
    """Write `index.h5` anew: `/trials/000001` leads to `trials/000001.h5`.

    It is derived from the folder, so it is not synced to the disk; after a power cut the next
    writer rebuilds it.

    Parameters
    ----------
    folder : Path
        Study folder.
    numbers : iterable of int
        Trials to link.
    study_text : str
        Study file as given, kept as the attribute `study`.

    Raises
    ------
    OSError
        The index could not be written; an older one is untouched.
    """

    def fill(root: Any) -> None:
        root.attrs["study"] = study_text
        trials = root.create_group("trials")
        for number in numbers:
            name = trial_name(number)
            trials[name] = h5py.ExternalLink(f"trials/{name}.h5", "/")

    path = folder / INDEX_NAME
    write_whole(path, sealed(file_image(fill)), durable=False)
    return path


def study_text_in_index(folder: Path) -> str | None:
    """Copy of the study file that the index keeps; None where the index is missing or damaged."""
    path = folder / INDEX_NAME
    try:
        if read_seal(path.read_bytes()).state != "intact":
            return None
        with h5py.File(path, "r", locking=False) as file:
            return str(file.attrs["study"])
    except (OSError, KeyError):
        return None
