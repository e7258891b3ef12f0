"""Libraries that lie beside an FMU's own, and that the system's loader does not look for there."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

_MISSING = re.compile(r"(?P<name>[^\s/:]+\.so[.\d]*): cannot open shared object")


def with_libraries_beside(library: Path, load: Callable[[], Any]) -> Any:
    """Load a library after those beside it that it needs, one by one as the loader names them.

    Many exporters set no search path in their library. A library that is loaded already is found
    by its name, wherever it lies.

    Parameters
    ----------
    library : Path
        Of the FMU; only files in its folder are loaded.
    load : callable
        Loads it; raises an exception with the loader's words.
    """
    loaded: set[str] = set()
    while True:
        try:
            return load()
        except Exception as error:
            missing = _missing_beside(library.parent, str(error), loaded)
            if missing is None:
                raise
            _load(missing, loaded)


def _load(library: Path, loaded: set[str]) -> None:
    loaded.add(library.name)
    while True:
        try:
            # Its symbols are for the FMU's library, which was linked against it.
            ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
            return
        except OSError as error:
            missing = _missing_beside(library.parent, str(error), loaded)
            if missing is None:
                return  # the loader will say so for the FMU's own library
            _load(missing, loaded)


def _missing_beside(folder: Path, text: str, loaded: set[str]) -> Path | None:
    found = _MISSING.search(text)
    if found is None or found["name"] in loaded or not (folder / found["name"]).is_file():
        return None
    return folder / found["name"]
