"""Write the text of a twin file."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable


def toml_text(value: str) -> str:
    """TOML basic string, whose escapes are those of JSON but for the control character DEL."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")


def toml_table(name: str, story: str, lines: Iterable[str]) -> str:
    """Text of a table; empty without entries, except for the obligatory [outputs]."""
    body = list(lines)
    if not body and name != "outputs":
        return ""
    return f"[{name}]  # {story}\n" + "".join(f"{line}\n" for line in body)


def bare_key(name: str) -> str:
    """TOML key that needs no quotes, from the name of a variable."""
    return re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_") or "signal"


def free_key(name: str, taken: set[str]) -> str:
    """A free key by this name, numbered where taken; the key is then added to `taken`."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    taken.add(free)
    return free
