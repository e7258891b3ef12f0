"""Where the project's own FMUs and twin files lie."""

from __future__ import annotations

from pathlib import Path


def models_folder() -> Path:
    """Folder of built FMUs, the same call in a checkout, an editable install and a wheel."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "_models"
    return installed if installed.is_dir() else package.parent / "models"
