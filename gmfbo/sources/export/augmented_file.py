"""The twin file of an augmented twin: the user's twin file, changed to one FMU."""

from __future__ import annotations

import json
import os
import re
import textwrap
from collections.abc import Mapping
from pathlib import Path

from gmfbo.sources.twin_file.twin_file import TwinFile

# A table's nodes in force are local variables, which the container does not show.
_LEFT_OUT = {"name", "fmu", "fmus", "wires", "step", "parameters", "tables", "origin"}


def augmented_twin_file(
    file: TwinFile, fmu: str, step: float, note: str, values: Mapping[str, float]
) -> str:
    """Write the twin file; values of [parameters] have become start values of the FMU.

    Parameters
    ----------
    file : TwinFile
        Of the twin.
    fmu : str
        Path of the augmented FMU.
    step : float
        [s] Communication step.
    note : str
        Description of the FMU, for a comment at the top.
    values : mapping of str to float
        [FMU's unit] Values in the FMU, also of fixed gains.
    """
    given = file.model_dump(exclude_unset=True, exclude=_LEFT_OUT)
    for name, gain in given.get("gains", {}).items():
        if gain["low"] == gain["high"]:
            gain["low"] = gain["high"] = float(values.get(name, gain["low"]))
    lines = [f"# {line}" for line in textwrap.wrap(note, 97)]
    lines += [f"name = {_value(file.name + ', augmented')}", f"fmu = {_value(fmu)}"]
    lines.append(f"step = {_value(step)}")
    # TOML wants single values above the first table: warm-up, dialect, stop time, time limit.
    single = {key: value for key, value in given.items() if not isinstance(value, Mapping)}
    lines += [f"{key} = {_value(value)}" for key, value in single.items() if value is not None]
    for table, entries in given.items():
        if entries and table not in single:
            lines += ["", f"[{table}]"]
            lines += [f"{_key(name)} = {_entry(entry)}" for name, entry in entries.items()]
    return "\n".join(lines) + "\n"


def with_origin(text: str, origin: Path, folder: Path) -> str:
    """Name the twin file that was augmented, so that both can be drawn side by side.

    Parameters
    ----------
    text : str
        From `augmented_twin_file`.
    origin : Path
        Twin file of the user's twin.
    folder : Path
        Folder that the text is written to: a path from there outlives a move of both.

    Returns
    -------
    str
        With one more line, above that of the step.
    """
    try:
        path = Path(os.path.relpath(origin.resolve(), folder.resolve()))
    except ValueError:  # on another drive of Windows
        path = origin.resolve()
    named = f"origin = {_value(path.as_posix())}\n"
    text = re.sub("^origin = .*\n", "", text, count=1, flags=re.MULTILINE)
    return re.sub("^step = ", lambda step: named + step[0], text, count=1, flags=re.MULTILINE)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _entry(entry: object) -> str:
    """An entry of a table, in the short form where possible."""
    if not isinstance(entry, Mapping):
        return _value(entry)
    if set(entry) == {"variable"}:
        return _value(entry["variable"])
    if set(entry) == {"column"}:
        return _value(entry["column"])
    if set(entry) == {"low", "high"}:
        low, high = entry["low"], entry["high"]
        return _value(low) if low == high else _value([low, high])
    pairs = (f"{name} = {_value(value)}" for name, value in entry.items() if value is not None)
    return "{ " + ", ".join(pairs) + " }"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    # A TOML basic string escapes as JSON does, but for DEL, which JSON leaves as it is.
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
