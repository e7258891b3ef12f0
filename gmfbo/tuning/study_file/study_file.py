"""The study file: what is tuned, on which sources, by which method, for how long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from gmfbo.errors import StudyFileError, did_you_mean
from gmfbo.files.toml_text import parse_toml, read_toml_text
from gmfbo.tuning.study_file.drift_section import DriftSection
from gmfbo.tuning.study_file.reference_section import DisturbanceSection, ReferenceSection
from gmfbo.tuning.study_file.study_sections import (
    BudgetSection,
    CompareSection,
    Normalisation,
    ObjectiveSection,
    PlantChange,
    PlantSection,
    StudyFile,
    TwinSection,
)

_SECTIONS: dict[str, type[BaseModel]] = {
    "": StudyFile,
    "is1": PlantSection,
    "is1.change": PlantChange,
    "is2": TwinSection,
    "reference": ReferenceSection,
    "reference.disturbance": DisturbanceSection,
    "objective": ObjectiveSection,
    "objective.normalise": Normalisation,
    "budget": BudgetSection,
    "drift": DriftSection,
    "compare": CompareSection,
}
_TABLES = {
    *("is1", "is2", "gains", "reference", "objective", "constraints", "safety", "drift", "budget"),
    "compare",
}


def parse_study(text: str, *, label: str, default_name: str) -> StudyFile:
    """Read and validate the text of a study file.

    Parameters
    ----------
    text : str
        TOML.
    label : str
        Name of the file, for messages.
    default_name : str
        Name of the study where the file states none.

    Raises
    ------
    StudyFileError
        Not TOML, or not a study: one line that lists everything wrong.
    """
    try:
        raw = parse_toml(text)
    except ValueError as error:
        raise StudyFileError(f"{label}: not a TOML file: {error}") from None
    try:
        return StudyFile.model_validate({"name": default_name, **raw})
    except ValidationError as error:
        findings = "; ".join(_finding(dict(detail)) for detail in error.errors())
        raise StudyFileError(f"{label}: {findings}") from None


def read_study_file(path: Path) -> tuple[StudyFile, str]:
    """Read a study file, and return it with its text as given.

    Parameters
    ----------
    path : Path
        The `.toml` file.

    Raises
    ------
    StudyFileError
        The file cannot be read or is not a study.
    """
    try:
        text = read_toml_text(path)
    except (OSError, ValueError) as error:
        reason = "not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)
        reason = getattr(error, "strerror", None) or reason
        raise StudyFileError(f"{path}: cannot read the study file: {reason}") from None
    return parse_study(text, label=path.name, default_name=path.stem), text


FIRST_DEFAULT = "gmfbo_physics"
"""Default method when begun studies did not log theirs yet."""


def as_begun(file: StudyFile, events: Sequence[Mapping[str, Any]]) -> StudyFile:
    """The study file with the method that the study was begun with, where the file states none.

    Parameters
    ----------
    file : StudyFile
        As read.
    events : sequence of mapping
        Of the study's log; empty before it was begun.
    """
    begun = [event for event in events if event["event"] == "begin"]
    if not begun or "method" in file.model_fields_set:
        return file
    return file.model_copy(update={"method": begun[0].get("method", FIRST_DEFAULT)})


def _finding(detail: dict[str, Any]) -> str:
    """A validation error in the words of the file."""
    location = [str(part) for part in detail["loc"]]
    # A single [reference] was turned into a list, whose index the file does not have.
    if location[:2] == ["reference", "0"]:
        del location[1]
    message = str(detail["msg"]).removeprefix("Value error, ")
    if detail["type"] == "extra_forbidden":
        choices = _keys_at(location[:-1])
        message = f"unknown key '{location[-1]}'" + did_you_mean(location[-1], choices)
        location = location[:-1]
    elif detail["type"] == "missing":
        message = "missing"
    if not location:
        return message
    table, keys = location[0], ".".join(location[1:])
    place = f"[{table}] {keys}".strip() if table in _TABLES else ".".join(location)
    return f"{place}: {message}"


def _keys_at(location: list[str]) -> list[str]:
    """Valid keys at a place; empty where the place is a free table."""
    section = _SECTIONS.get(".".join(location))
    fields = section.model_fields if section else {}
    return [field.alias or name for name, field in fields.items()]
