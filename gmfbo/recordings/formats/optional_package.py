"""Load optional packages when a file that needs them is read."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from gmfbo.errors import RecordingError


def load_package(module: str, extra: str, label: str) -> Any:
    """Import a package that belongs to an extra of gmfbo.

    Raises
    ------
    RecordingError
        It is not installed; the message gives the command that installs it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        why = "is not installed" if error.name == package else f"cannot be loaded ({error})"
        raise RecordingError(
            f"{label}: expected the package '{package}' to read it, but it {why}; "
            f"run: pip install 'gmfbo[{extra}]'"
        ) from error
