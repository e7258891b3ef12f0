"""An FMU on disk, ready to be loaded by this or another process."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class UnpackedFmu:
    """An FMU unpacked to a folder.

    Attributes
    ----------
    name : str
        File name, for messages.
    guid, identifier : str
        As in the model description.
    folder : str
        Folder that it is unpacked to.
    library : str
        Path of the shared library.
    fmi : int
        Major version of FMI: 2 or 3.
    """

    name: str
    guid: str
    identifier: str
    folder: str
    library: str
    fmi: int = 2
