"""Paths of the project's own FMUs and twin files."""

from __future__ import annotations

import os
from pathlib import Path

from gmfbo.errors import InputError


def models_folder() -> Path:
    """Folder of built FMUs, the same call in a checkout, an editable install and a wheel."""
    package = Path(__file__).resolve().parents[2]
    installed = package / "_models"
    return installed if installed.is_dir() else package.parent / "models"


def physics_fmu() -> Path:
    """The FMU that holds the laws of all effects: ours, or that of `GMFBO_PHYSICS`.

    Raises
    ------
    InputError
        The environment variable names no file.
    """
    own = os.environ.get("GMFBO_PHYSICS")
    if not own:
        return models_folder() / "physics.fmu"
    path = Path(own)
    if not path.is_file():
        raise InputError(
            f"GMFBO_PHYSICS: expected a file with laws of your own, but there is no '{own}'; "
            "build it, or unset the variable"
        )
    return path
