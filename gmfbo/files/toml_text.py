"""Read TOML of bounded size, depth and numbers, as a person would write it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from gmfbo.errors import in_short

LARGEST_BYTES = 4 * 2**20
_LARGEST_INTEGER = 2**63  # TOML 1.0: integers have 64 bits


def read_toml_text(path: Path) -> str:
    """Text of a TOML file.

    Raises
    ------
    OSError
        It cannot be read.
    ValueError
        It is not UTF-8, or too large for such a file.
    """
    if path.stat().st_size > LARGEST_BYTES:
        raise ValueError(
            f"expected at most {LARGEST_BYTES / 1e6:.0f} MB of text, got "
            f"{path.stat().st_size / 1e6:.0f} MB"
        )
    return path.read_text(encoding="utf-8")


def parse_toml(text: str) -> dict[str, Any]:
    """Tables and values of a TOML text.

    Raises
    ------
    ValueError
        It is not TOML, is nested too deeply, or holds an integer of more than 64 bits; one line.
    """
    try:
        content = tomllib.loads(text)
        _check_integers(content)
    except RecursionError:
        raise ValueError("tables or lists are nested too deeply") from None
    except ValueError as error:
        raise ValueError(in_short(error)) from None
    return content


def _check_integers(value: object) -> None:
    if isinstance(value, dict):
        for entry in value.values():
            _check_integers(entry)
    elif isinstance(value, list):
        for entry in value:
            _check_integers(entry)
    elif isinstance(value, int) and not -_LARGEST_INTEGER <= value < _LARGEST_INTEGER:
        raise ValueError("expected integers of at most 64 bits, got a larger one")
