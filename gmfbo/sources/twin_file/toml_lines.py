"""Write the text of a twin file, and find an entry in it."""

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


def line_of(text: str, table: str, key: str) -> int | None:
    """Number of the line on which a table's entry begins, from 1; None where it has no own line.

    Parameters
    ----------
    text : str
        Of a TOML file.
    table : str
        Name of a table that begins with a line `[table]`.
    key : str
        Of the entry, without quotes.
    """
    entry = re.compile(rf"""\s*(["']?){re.escape(key)}\1\s*=""")
    header = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]")
    within = ""
    for number, line in enumerate(text.splitlines(), 1):
        if begun := header.match(line):
            within = begun[1]
        elif within == table and entry.match(line):
            return number
    return None
