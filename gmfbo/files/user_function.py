"""A function of the user, loaded from the file that a study names."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gmfbo.errors import InputError, did_you_mean


def load_function(label: str, folder: Path, key: str) -> Callable[..., Any]:
    """Load a function from its file.

    Parameters
    ----------
    label : str
        `FILE.py:FUNCTION`.
    folder : Path
        Folder to which the path is relative.
    key : str
        Key of the study file, for messages.

    Raises
    ------
    InputError
        There is no such file or function, or the file cannot be imported.
    """
    file, _, name = label.rpartition(":")
    path = folder / file
    if not file.endswith(".py") or not name.isidentifier():
        raise InputError(f"{key}: expected \"FILE.py:FUNCTION\", got '{label}'")
    if not path.is_file():
        raise InputError(f"{key}: no file '{path}'")
    spec = importlib.util.spec_from_file_location(f"gmfbo_own_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"{key}: '{file}' cannot be imported: {said}") from error
    function: Callable[..., Any] | None = getattr(module, name, None)
    if function is None or not callable(function):
        hint = did_you_mean(name, [n for n, value in vars(module).items() if callable(value)])
        raise InputError(f"{key}: '{file}' has no function '{name}'{hint}")
    return function
