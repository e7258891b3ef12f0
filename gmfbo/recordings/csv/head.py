"""The `# name = value` lines at the top of a CSV recording.

Reserved names are `gmfbo` (version that wrote the file), `use`, `start_time` and names that begin
with `gmfbo.`; any other number is an FMU parameter in force.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from gmfbo.errors import RecordingError
from gmfbo.recordings.columns.columns import FileNotes

RESERVED = ("gmfbo", "use", "start_time")
OWN = "gmfbo."
RUN_KEYS = (
    "status",
    "message",
    "stopped_at",
    "seconds",
)  # fields of a Trajectory beyond a Recording's


@dataclass(frozen=True)
class CsvHead:
    """Content of the lines above the header.

    Attributes
    ----------
    parameters : dict of str to float
        FMU parameters in force.
    unreadable : dict of str to str
        Messages about values that are no numbers, by name.
    notes : FileNotes
        Metadata of the file.
    """

    parameters: dict[str, float] = field(default_factory=dict)
    unreadable: dict[str, str] = field(default_factory=dict)
    notes: FileNotes = field(default_factory=FileNotes)


def read_head(lines: Sequence[str], label: str) -> CsvHead:
    """Parse the `#` lines; lines without `=` are remarks.

    Raises
    ------
    RecordingError
        `use` is not two times.
    """
    parameters: dict[str, float] = {}
    unreadable: dict[str, str] = {}
    own: dict[str, Any] = {}
    schedules = []
    for line in lines:
        text = line.lstrip().lstrip("#").strip()
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            continue
        if key in RESERVED:
            own[key] = value
        elif key == f"{OWN}schedule":
            schedules.append(value)
        elif key.startswith(OWN):
            own[key] = _json(key, value, label)
        else:
            # A quoted FMI name may itself hold an equals sign; a number cannot.
            name, _, value = (part.strip() for part in text.rpartition("="))
            try:
                parameters[name] = float(_decimal_point(value))
            except ValueError:
                unreadable[name] = (
                    f"{label}: '# {name} = {value}': expected a number for this FMU parameter; "
                    "correct the line"
                )
    copied = own.pop(f"{OWN}logger", None) is not None
    run = {key: own[OWN + key] for key in RUN_KEYS if OWN + key in own}
    notes = FileNotes(
        use=_use(own["use"], label) if "use" in own else None,
        start_time=own.get("start_time", ""),
        written_by="" if copied else own.get("gmfbo", ""),
        own="gmfbo" in own,
        schedules=frozenset(schedules),
        run=run or None,
    )
    return CsvHead(parameters, unreadable, notes)


def _json(key: str, text: str, label: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        raise RecordingError(
            f"{label}: '# {key} = {text}': expected a number or a quoted text; restore the line, "
            "or delete it"
        ) from None


def _use(text: str, label: str) -> tuple[float, float]:
    first, colon, last = text.partition(":")
    try:
        if not colon:
            raise ValueError
        return float(_decimal_point(first)), float(_decimal_point(last))
    except ValueError:
        raise RecordingError(
            f"{label}: '# use = {text}': expected first and last time in seconds, such as "
            "'# use = 0.20:3.40'; correct the line"
        ) from None


def _decimal_point(text: str) -> str:
    return text.strip().replace(",", ".") if text.count(",") == 1 else text.strip()
